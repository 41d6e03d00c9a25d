/*
 * Every call of sinew.h once, as it is meant: `tour RIG`, a simulated rig with the channels left and right, whose sensors have proved themselves.
 */
#define _POSIX_C_SOURCE 200809L
#include "check.h"

#include <math.h>
#include <signal.h>
#include <sys/types.h>
#include <time.h>

static SinewSnapshot snapshot;
static SinewCycle cycle;
static SinewChannelInfo channels[SINEW_MAX_CHANNELS];

static void rest(long ms) {
    const struct timespec time = {0, ms * 1000000L};
    nanosleep(&time, NULL);
}

/* The latest state once the driver has written another one. */
static void look_again(const SinewClient *client) {
    CHECK(sinew_wait(client, 60.0) == SINEW_OK);
    CHECK(sinew_wait(client, 60.0) == SINEW_OK);
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK);
}

int main(int count, char **arguments) {
    CHECK(count == 2);
    const char *const rig = arguments[1];
    CHECK(sinew_abi() == SINEW_ABI && sinew_protocol() == SINEW_PROTOCOL);
    CHECK(sinew_last_error()[0] == '\0' && sinew_last_remedy()[0] == '\0' && sinew_refusals() == 0);

    /* Connect, and what does not change. */
    static char rigs[64][SINEW_NAME_SIZE];
    size_t found = 0;
    CHECK(sinew_discover(NULL, 0, &found) == SINEW_OK && found >= 1);
    CHECK(sinew_discover(rigs, 64, &found) == SINEW_OK);
    int is_there = 0;
    for (size_t i = 0; i < found && i < 64; i++) {
        is_there |= strcmp(rigs[i], rig) == 0;
    }
    CHECK(is_there);
    SinewClient *client = NULL;
    CHECK(sinew_connect(rig, &client) == SINEW_OK && client != NULL);
    SinewInfo info;
    CHECK(sinew_info(client, &info) == SINEW_OK);
    CHECK(info.protocol == SINEW_PROTOCOL && info.pid > 0 && strcmp(info.rig, rig) == 0 && info.rate_hz == 500.0);
    CHECK(info.started_ns > 0 && info.started_ns < sinew_monotonic_ns() && info.channels == 2 && info.simulated == 1 && info.foreign == 0);
    int64_t system_ns = 0;
    uint64_t error_ns = 0;
    struct timespec earlier, later;
    clock_gettime(CLOCK_REALTIME, &earlier);
    uint64_t stamp = sinew_monotonic_ns();
    clock_gettime(CLOCK_REALTIME, &later);
    CHECK(sinew_system_time(stamp, &system_ns, &error_ns) == SINEW_OK && error_ns > 0 && error_ns < 10000000);
    CHECK(system_ns + (int64_t)error_ns >= (int64_t)earlier.tv_sec * 1000000000 + earlier.tv_nsec);
    CHECK(system_ns - (int64_t)error_ns <= (int64_t)later.tv_sec * 1000000000 + later.tv_nsec);
    CHECK(sinew_system_time(stamp, NULL, &error_ns) == SINEW_ERROR_ARGUMENT);

    /* Another clock, 30 ppm fast, that is asked every second and answers within 40 µs. */
    SinewClockRules rules;
    CHECK(sinew_clock_rules(&rules) == SINEW_OK && rules.max_rate_ppm == 200.0 && rules.pairs == 128);
    rules.max_rate_ppm = 100.0;
    SinewClockMap *clock = NULL;
    CHECK(sinew_clock_map(&rules, &clock) == SINEW_OK && clock != NULL);
    SinewClockChange set = {SINEW_CLOCK_NEWS_UNSTEADY, 1};
    uint64_t driver_ns = 0;
    double rate_ppm = 0.0, rate_error_ppm = 0.0;
    CHECK(sinew_clock_map_driver_at(clock, 0, &driver_ns, &error_ns) == SINEW_NOTHING);
    for (uint64_t second = 1; second <= 20; second++) {
        const int64_t shown = (int64_t)(second * 1000030000);
        CHECK(sinew_clock_map_bracket(clock, second * 1000000000 - 20000, shown, second * 1000000000 + 20000, &set) == SINEW_OK);
        CHECK(set.news == SINEW_CLOCK_NEWS_NONE && set.by_ns == 0);
    }
    CHECK(sinew_clock_map_driver_at(clock, 10000300000, &driver_ns, &error_ns) == SINEW_OK && error_ns < 40000);
    CHECK(driver_ns + error_ns >= 10000000000 && driver_ns <= 10000000000 + error_ns);
    int64_t other_ns = 0;
    CHECK(sinew_clock_map_other_at(clock, 10000000000, &other_ns, &error_ns) == SINEW_OK);
    CHECK(other_ns + (int64_t)error_ns >= 10000300000 && other_ns - (int64_t)error_ns <= 10000300000);
    CHECK(sinew_clock_map_rate(clock, &rate_ppm, &rate_error_ppm) == SINEW_OK && fabs(rate_ppm - 30.0) <= rate_error_ppm);
    CHECK(sinew_clock_map_pair(clock, 21000000000, 21000630000, 1000, NULL) == SINEW_OK);
    CHECK(sinew_clock_map_late(clock, 22000000000, 5, &set) == SINEW_OK);
    CHECK(set.news == SINEW_CLOCK_NEWS_WENT_BACK && set.by_ns == 5 - 21000630000);
    CHECK(sinew_clock_map_close(clock) == SINEW_OK && sinew_clock_map_close(NULL) == SINEW_OK);
    CHECK(sinew_clock_map_rate(clock, &rate_ppm, &rate_error_ppm) == SINEW_ERROR_HANDLE);
    CHECK(sinew_clock_map(NULL, &clock) == SINEW_OK && sinew_clock_map_close(clock) == SINEW_OK);

    channels[1].lease_s = -1.0;
    CHECK(sinew_channels(client, channels, 1, &found) == SINEW_OK && found == 2 && channels[1].lease_s == -1.0);
    CHECK(sinew_channels(client, channels, SINEW_MAX_CHANNELS, &found) == SINEW_OK && found == 2);
    CHECK(strcmp(channels[0].name, "left") == 0 && strcmp(channels[1].name, "right") == 0);
    CHECK(channels[1].lease_s == 0.5 && channels[0].hot_length_m < channels[0].cold_length_m && channels[0].rest_length_m == 0.16);
    uint32_t left = 9, right = 9;
    CHECK(sinew_channel(client, "left", &left) == SINEW_OK && left == 0);
    CHECK(sinew_channel(client, "right", &right) == SINEW_OK && right == 1);
    size_t needed = 0;
    CHECK(sinew_rig_text(client, NULL, 0, &needed) == SINEW_OK && needed > 100);
    char *const text = calloc(needed, 1);
    CHECK(text != NULL && sinew_rig_text(client, text, needed, &needed) == SINEW_OK && strlen(text) == needed - 1);
    CHECK(strstr(text, "[[channel]]") != NULL);
    CHECK(sinew_rig_text(client, text, 6, &needed) == SINEW_OK && strcmp(text, "[rig]") == 0);
    free(text);

    /* State. */
    snapshot.channel[2].duty = -1.0;
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK);
    CHECK(snapshot.cycle > 0 && snapshot.channels == 2 && snapshot.state == SINEW_DRIVER_STATE_RUNNING);
    CHECK(snapshot.channel[2].duty == -1.0 && snapshot.channel[left].resistance_ohm > 1.0);
    CHECK(strcmp(sinew_mode_name(snapshot.channel[left].mode), "off") == 0);
    SinewDriverHealth health = SINEW_DRIVER_HEALTH_DIED;
    double age_s = -1.0;
    CHECK(sinew_health(client, &health, &age_s) == SINEW_OK && health == SINEW_DRIVER_HEALTH_RUNNING && age_s >= 0.0);
    CHECK(sinew_health(client, NULL, NULL) == SINEW_OK);

    /* Every cycle. */
    SinewCycleStream *stream = NULL;
    CHECK(sinew_stream(client, &stream) == SINEW_OK && stream != NULL);
    uint64_t before = 0, received = 0, lost = 0, said_lost = 0;
    cycle.channel[2].duty = -1.0;
    for (int i = 0; i < 100; i++) {
        CHECK(sinew_stream_next(stream, 60.0, &cycle) == SINEW_OK);
        CHECK(cycle.channels == 2 && cycle.monotonic_ns > info.started_ns && cycle.channel[2].duty == -1.0);
        CHECK(before == 0 || cycle.cycle == before + 1 + cycle.lost);
        before = cycle.cycle;
        said_lost += cycle.lost;
    }
    CHECK(sinew_stream_counts(stream, &received, &lost) == SINEW_OK && received == 100 && lost == said_lost);
    CHECK(sinew_stream_counts(stream, NULL, NULL) == SINEW_OK);
    int status = SINEW_OK;
    while (status == SINEW_OK) {
        status = sinew_stream_next(stream, 0.0, &cycle);
    }
    CHECK(status == SINEW_NOTHING);

    /* Commands, and what comes of them. */
    SinewFaultWatch *faults = NULL;
    SinewFaultChange change;
    CHECK(sinew_faults(client, &faults) == SINEW_OK && faults != NULL);
    CHECK(sinew_faults_next(faults, 0.0, &change) == SINEW_NOTHING);
    CHECK(sinew_set_stroke(client, "left", 0.3, 60.0) == SINEW_OK);
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK && snapshot.channel[left].mode == SINEW_MODE_LENGTH);
    const double asked_m = channels[left].cold_length_m + 0.3 * (channels[left].hot_length_m - channels[left].cold_length_m);
    CHECK(fabs(snapshot.channel[left].target_m - asked_m) < 1e-9);
    CHECK(sinew_set_length(client, "left", asked_m + 1e-4, 60.0) == SINEW_OK);
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK && fabs(snapshot.channel[left].target_m - asked_m - 1e-4) < 1e-9);
    CHECK(sinew_set_duty(client, "right", 0.1, 60.0) == SINEW_OK);
    look_again(client);
    CHECK(snapshot.channel[right].mode == SINEW_MODE_DUTY && fabs(snapshot.channel[right].duty - 0.1) < 1e-12);
    CHECK(sinew_set_force(client, "right", 2.0, 60.0) == SINEW_OK);
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK && snapshot.channel[right].mode == SINEW_MODE_FORCE);
    SinewTaken taken = {0, -1.0};
    CHECK(sinew_set(client, "right", SINEW_COMMAND_KIND_STROKE, 0.2, 0.0, &taken) == SINEW_OK);
    CHECK(taken.cycle > before && taken.hold_s == channels[right].lease_s);
    const SinewWanted pose[] = {{left, SINEW_COMMAND_KIND_STROKE, 0.1}, {right, SINEW_COMMAND_KIND_OFF, 0.0}};
    CHECK(sinew_set_many(client, pose, 2, 0.25, &taken) == SINEW_OK && taken.hold_s == 0.25);
    CHECK(sinew_set_many(client, pose, 2, 0.25, NULL) == SINEW_OK);
    const uint32_t both[] = {0, 1};
    CHECK(sinew_claim(client, both, 2, 5, 0.5, &taken) == SINEW_OK && taken.hold_s == 0.5);
    CHECK(sinew_set_many(client, pose, 2, 0.25, NULL) == SINEW_OK);
    CHECK(sinew_release(client, both, 2) == SINEW_OK);

    /* A stream of setpoints: nobody waits, the newest is in force, and what became of each is counted. */
    SinewSetpoints *setpoints = NULL;
    SinewSetpointProgress progress;
    CHECK(sinew_setpoints(client, 0.25, 0.1, 0.0, &setpoints) == SINEW_OK);
    for (int i = 0; i < 50; i++) {
        CHECK(sinew_setpoints_send(setpoints, pose, 2, &progress) == SINEW_OK && progress.sent == (uint64_t)i + 1);
    }
    do {
        CHECK(sinew_setpoints_poll(setpoints, &progress) == SINEW_OK);
    } while (progress.taken + progress.overtaken + progress.held_back < 50);
    CHECK(progress.taken > 0 && progress.late == 0 && progress.refused == 0 && progress.cycle > before);
    const SinewWanted beyond[] = {{left, SINEW_COMMAND_KIND_STROKE, 7.0}};
    CHECK(sinew_setpoints_send(setpoints, beyond, 1, NULL) == SINEW_OK);
    while (sinew_setpoints_poll(setpoints, &progress) == SINEW_OK) {
    }
    CHECK(sinew_setpoints_send(setpoints, pose, 2, &progress) == SINEW_OK && progress.refused == 1);
    CHECK(sinew_setpoints_close(setpoints) == SINEW_OK && sinew_setpoints_close(setpoints) == SINEW_ERROR_HANDLE);
    CHECK(sinew_set_many(client, pose, 2, 0.25, NULL) == SINEW_OK);
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK && snapshot.channel[right].mode == SINEW_MODE_OFF);

    /* The lease of left runs out: that is no fault, and the next setpoint is simply taken. */
    do {
        look_again(client);
    } while (snapshot.channel[left].mode != SINEW_MODE_LAPSED);
    CHECK(snapshot.channel[left].fault == 0 && strcmp(sinew_mode_name(snapshot.channel[left].mode), "lapsed") == 0);
    CHECK(sinew_faults_next(faults, 0.0, &change) == SINEW_NOTHING);
    CHECK(sinew_set_stroke(client, "left", 0.2, 60.0) == SINEW_OK);

    /* The driver stands still for half a second: a fault of both channels, which the watch tells, with words. */
    CHECK(kill((pid_t)info.pid, SIGSTOP) == 0);
    rest(500);
    CHECK(kill((pid_t)info.pid, SIGCONT) == 0);
    for (uint32_t channel = left; channel <= right; channel++) {
        CHECK(sinew_faults_next(faults, 60.0, &change) == SINEW_OK);
        CHECK(change.channel == channel && change.before == 0 && change.after == SINEW_FAULT_CYCLE_OVERRUN && change.cycle > taken.cycle);
    }
    CHECK(strcmp(sinew_fault_flag(change.after), "cycle_overrun") == 0 && change.monotonic_ns > info.started_ns);
    CHECK(strstr(sinew_fault_cause(change.after), "late") != NULL && sinew_fault_remedy(change.after)[0] != '\0');
    /* It may have been heated all along, and has to cool first. */
    while ((status = sinew_reset(client, "left")) == SINEW_ERROR_REFUSED) {
        rest(50);
    }
    CHECK(status == SINEW_OK);
    CHECK(sinew_faults_next(faults, 60.0, &change) == SINEW_OK && change.channel == left && change.after == 0);
    CHECK(sinew_set_stroke(client, "left", 0.2, 60.0) == SINEW_OK);
    CHECK(sinew_off(client, "left") == SINEW_OK);
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK && snapshot.channel[left].mode == SINEW_MODE_OFF);
    CHECK(sinew_set_stroke(client, "left", 0.2, 60.0) == SINEW_OK);
    CHECK(sinew_all_off(client) == SINEW_OK);
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK && snapshot.channel[left].mode == SINEW_MODE_OFF);

    SinewLoopStats stats;
    CHECK(sinew_loop_stats(client, &stats) == SINEW_OK);
    CHECK(stats.allocations == 0 && stats.dead_threads == 0 && stats.lateness.p50_ns <= stats.lateness.max_ns);

    /* A second client has patience of its own; what was opened with a client outlives it. */
    SinewClient *other = NULL;
    CHECK(sinew_connect_with(rig, INFINITY, INFINITY, &other) == SINEW_OK && other != client);
    CHECK(sinew_off(other, "left") == SINEW_OK);
    CHECK(sinew_close(client) == SINEW_OK);
    CHECK(sinew_stream_next(stream, 60.0, &cycle) == SINEW_OK);
    CHECK(sinew_faults_next(faults, 0.0, &change) == SINEW_NOTHING);

    /* Stop: the stream first gives what had been sent, and the latest state stays. */
    CHECK(sinew_stop(other) == SINEW_OK);
    do {
        status = sinew_stream_next(stream, 60.0, &cycle);
    } while (status == SINEW_OK);
    CHECK(status == SINEW_ERROR_DRIVER_GONE);
    do {
        status = sinew_faults_next(faults, 60.0, &change);
    } while (status == SINEW_OK);
    CHECK(status == SINEW_ERROR_DRIVER_GONE);
    CHECK(sinew_latest(other, &snapshot) == SINEW_OK && snapshot.cycle >= before && snapshot.channel[left].duty == 0.0);
    CHECK(sinew_health(other, &health, NULL) == SINEW_OK && health == SINEW_DRIVER_HEALTH_STOPPED);
    FAILS(sinew_set_stroke(other, "left", 0.1, 1.0), SINEW_ERROR_DRIVER_GONE, "has stopped; start the driver again");
    FAILS(sinew_wait(other, 60.0), SINEW_ERROR_DRIVER_GONE, "has stopped");

    CHECK(sinew_stream_close(stream) == SINEW_OK && sinew_faults_close(faults) == SINEW_OK && sinew_close(other) == SINEW_OK);
    CHECK(sinew_stream_close(NULL) == SINEW_OK && sinew_faults_close(NULL) == SINEW_OK && sinew_close(NULL) == SINEW_OK);
    puts("seen all");
    return 0;
}
