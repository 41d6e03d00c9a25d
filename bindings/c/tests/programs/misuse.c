/*
 * Everything that can be done wrong, each answered with an error and its remedy: `misuse RIG`, a simulated rig with the channels left and right.
 * Under it the driver goes on, and no wire is heated.
 */
#define _POSIX_C_SOURCE 200809L

#include "check.h"

#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <sys/wait.h>
#include <unistd.h>

static SinewSnapshot snapshot;
static SinewCycle cycle;
static SinewChannelInfo channels[SINEW_MAX_CHANNELS];

/* An address that no struct has. */
static void *odd(void *place) {
    return (void *)((uintptr_t)place + 1);
}

static void connecting(void) {
    SinewClient *client = (SinewClient *)&snapshot;
    FAILS(sinew_connect(NULL, &client), SINEW_ERROR_ARGUMENT, "rig is null");
    CHECK(client == NULL);
    FAILS(sinew_connect("hexapod", NULL), SINEW_ERROR_ARGUMENT, "client is null");
    FAILS(sinew_connect("", &client), SINEW_ERROR_RIG_NAME, "is no rig name; use 1 to 48");
    FAILS(sinew_connect("no rig", &client), SINEW_ERROR_RIG_NAME, "is no rig name");
    FAILS(sinew_connect("../../etc/passwd", &client), SINEW_ERROR_RIG_NAME, "is no rig name");
    FAILS(sinew_connect("\xff\xfe", &client), SINEW_ERROR_ARGUMENT, "rig is no UTF-8");
    char endless[4096];
    memset(endless, 'x', sizeof endless);
    FAILS(sinew_connect(endless, &client), SINEW_ERROR_ARGUMENT, "rig has no end within 255 bytes");
    endless[100] = '\0';
    FAILS(sinew_connect(endless, &client), SINEW_ERROR_RIG_NAME, "is no rig name");
    FAILS(sinew_connect_with("nobodys-rig", 0.0, 1.0, &client), SINEW_ERROR_NOT_RUNNING, "no driver for rig \"nobodys-rig\" is running");
    CHECK(client == NULL);
    FAILS(sinew_connect_with("nobodys-rig", NAN, 1.0, &client), SINEW_ERROR_ARGUMENT, "connect_s = NaN is no time");
    FAILS(sinew_connect_with("nobodys-rig", 1.0, -1.0, &client), SINEW_ERROR_ARGUMENT, "answer_s = -1 is no time");
    FAILS(sinew_discover(NULL, 0, NULL), SINEW_ERROR_ARGUMENT, "found is null");
    size_t found = 0;
    FAILS(sinew_discover(NULL, 3, &found), SINEW_ERROR_ARGUMENT, "rigs is null");
}

static void clocks(void) {
    SinewClockMap *map = (SinewClockMap *)&snapshot;
    SinewClockRules rules;
    uint64_t driver_ns = 7, error_ns = 7;
    FAILS(sinew_clock_rules(NULL), SINEW_ERROR_ARGUMENT, "rules is null");
    FAILS(sinew_clock_map(odd(&rules), &map), SINEW_ERROR_ARGUMENT, "rules is at an odd address");
    CHECK(map == NULL);
    FAILS(sinew_clock_map(NULL, NULL), SINEW_ERROR_ARGUMENT, "map is null");
    FAILS(sinew_clock_map_bracket(NULL, 1, 2, 3, NULL), SINEW_ERROR_ARGUMENT, "the clock map is null; open a clock map first");
    FAILS(sinew_clock_map_late((SinewClockMap *)&rules, 1, 2, NULL), SINEW_ERROR_HANDLE, "this is no open clock map");
    /* What no clock does is taken for the most that is taken, and says nothing that is not so. */
    CHECK(sinew_clock_rules(&rules) == SINEW_OK);
    rules.max_rate_ppm = NAN;
    rules.drift_ppm_per_s = -INFINITY;
    rules.pairs = UINT32_MAX;
    CHECK(sinew_clock_map(&rules, &map) == SINEW_OK);
    CHECK(sinew_clock_map_bracket(map, UINT64_MAX, INT64_MIN, 0, NULL) == SINEW_OK);
    CHECK(sinew_clock_map_pair(map, 0, INT64_MAX, UINT64_MAX, NULL) == SINEW_OK);
    FAILS(sinew_clock_map_driver_at(map, 0, NULL, &error_ns), SINEW_ERROR_ARGUMENT, "driver_ns is null");
    FAILS(sinew_clock_map_driver_at(map, 0, &driver_ns, NULL), SINEW_ERROR_ARGUMENT, "error_ns is null");
    CHECK(driver_ns == 7 && error_ns == 7 && sinew_clock_map_close(map) == SINEW_OK);
    FAILS(sinew_clock_map_close(map), SINEW_ERROR_HANDLE, "this is no open clock map");
}

static void reading(SinewClient *client) {
    size_t found = 0;
    uint32_t number = 77;
    FAILS(sinew_info(client, NULL), SINEW_ERROR_ARGUMENT, "info is null");
    FAILS(sinew_channels(client, channels, 64, NULL), SINEW_ERROR_ARGUMENT, "found is null");
    FAILS(sinew_channels(client, odd(channels), 63, &found), SINEW_ERROR_ARGUMENT, "channels is at an odd address");
    FAILS(sinew_channel(client, "left", NULL), SINEW_ERROR_ARGUMENT, "number is null");
    FAILS(sinew_channel(client, NULL, &number), SINEW_ERROR_ARGUMENT, "channel is null");
    FAILS(sinew_channel(client, "lefd", &number), SINEW_ERROR_UNKNOWN_CHANNEL, "there is no channel \"lefd\"; did you mean \"left\"?");
    FAILS(sinew_channel(client, "middle", &number), SINEW_ERROR_UNKNOWN_CHANNEL, "there are: left, right");
    CHECK(number == 77);
    FAILS(sinew_rig_text(client, NULL, 9, &found), SINEW_ERROR_ARGUMENT, "text is null");
    FAILS(sinew_rig_text(client, NULL, 0, NULL), SINEW_ERROR_ARGUMENT, "needed is null");
    FAILS(sinew_latest(client, NULL), SINEW_ERROR_ARGUMENT, "snapshot is null; hand over the address");
    FAILS(sinew_latest(client, odd(&snapshot)), SINEW_ERROR_ARGUMENT, "snapshot is at an odd address");
    FAILS(sinew_loop_stats(client, NULL), SINEW_ERROR_ARGUMENT, "stats is null");
    FAILS(sinew_wait(client, NAN), SINEW_ERROR_ARGUMENT, "timeout_s = NaN is no time");
    FAILS(sinew_wait(client, -0.1), SINEW_ERROR_ARGUMENT, "timeout_s = -0.1 is no time");
    CHECK(sinew_wait(client, INFINITY) == SINEW_OK);
    FAILS(sinew_stream(client, NULL), SINEW_ERROR_ARGUMENT, "stream is null");
    FAILS(sinew_faults(client, NULL), SINEW_ERROR_ARGUMENT, "faults is null");

    SinewCycleStream *stream = NULL;
    SinewFaultWatch *faults = NULL;
    SinewFaultChange change;
    CHECK(sinew_stream(client, &stream) == SINEW_OK && sinew_faults(client, &faults) == SINEW_OK);
    FAILS(sinew_stream_next(stream, 1.0, NULL), SINEW_ERROR_ARGUMENT, "cycle is null");
    FAILS(sinew_stream_next(stream, NAN, &cycle), SINEW_ERROR_ARGUMENT, "timeout_s = NaN is no time");
    FAILS(sinew_stream_next(NULL, 1.0, &cycle), SINEW_ERROR_ARGUMENT, "the stream is null");
    FAILS(sinew_faults_next(faults, 1.0, NULL), SINEW_ERROR_ARGUMENT, "change is null");
    FAILS(sinew_faults_next(faults, -INFINITY, &change), SINEW_ERROR_ARGUMENT, "timeout_s = -inf is no time");
    FAILS(sinew_faults_next(NULL, 1.0, &change), SINEW_ERROR_ARGUMENT, "the fault watch is null");

    /* One for another, closed, closed twice, and what never was one. */
    FAILS(sinew_stream_next((SinewCycleStream *)client, 0.0, &cycle), SINEW_ERROR_HANDLE, "this is no open stream");
    FAILS(sinew_latest((SinewClient *)stream, &snapshot), SINEW_ERROR_HANDLE, "this is no open client");
    FAILS(sinew_latest((SinewClient *)&snapshot, &snapshot), SINEW_ERROR_HANDLE, "this is no open client");
    FAILS(sinew_latest((SinewClient *)UINTPTR_MAX, &snapshot), SINEW_ERROR_HANDLE, "this is no open client");
    CHECK(sinew_stream_close(stream) == SINEW_OK && sinew_faults_close(faults) == SINEW_OK);
    FAILS(sinew_stream_next(stream, 0.0, &cycle), SINEW_ERROR_HANDLE, "use a stream only between opening and closing it");
    FAILS(sinew_stream_counts(stream, NULL, NULL), SINEW_ERROR_HANDLE, "this is no open stream");
    FAILS(sinew_stream_close(stream), SINEW_ERROR_HANDLE, "close it once");
    FAILS(sinew_faults_close(faults), SINEW_ERROR_HANDLE, "close it once");

    /* Codes that stand for nothing. */
    CHECK(sinew_fault_flag(0)[0] == '\0' && sinew_fault_cause(UINT32_MAX)[0] == '\0' && sinew_fault_remedy(999)[0] == '\0');
    CHECK(sinew_mode_name(UINT32_MAX)[0] == '\0');
}

static void commanding(SinewClient *client) {
    FAILS(sinew_set_stroke(client, NULL, 0.1, 1.0), SINEW_ERROR_ARGUMENT, "channel is null");
    FAILS(sinew_set_stroke(NULL, "left", 0.1, 1.0), SINEW_ERROR_ARGUMENT, "the client is null; open a client first");
    FAILS(sinew_set_stroke(client, "lefd", 0.1, 1.0), SINEW_ERROR_UNKNOWN_CHANNEL, "did you mean \"left\"?");
    char endless[4096];
    memset(endless, 'x', sizeof endless);
    FAILS(sinew_set_stroke(client, endless, 0.1, 1.0), SINEW_ERROR_ARGUMENT, "channel has no end within 255 bytes");
    FAILS(sinew_set_duty(client, "left", NAN, 1.0), SINEW_ERROR_REFUSED, "duty or hold is not a finite number; send a finite number");
    FAILS(sinew_set_length(client, "left", INFINITY, 1.0), SINEW_ERROR_REFUSED, "not a finite number");
    FAILS(sinew_set_duty(client, "left", 0.1, NAN), SINEW_ERROR_ARGUMENT, "hold_s = NaN is no time");
    FAILS(sinew_set_duty(client, "left", 0.1, -1.0), SINEW_ERROR_ARGUMENT, "hold_s = -1 is no time");
    FAILS(sinew_set_duty(client, "left", 0.1, INFINITY), SINEW_ERROR_ARGUMENT, "hold_s = inf is no time");
    FAILS(sinew_set_duty(client, "left", 0.1, 1e9), SINEW_ERROR_REFUSED, "hold is outside");
    FAILS(sinew_set(client, "left", 0, 0.1, 1.0, NULL), SINEW_ERROR_ARGUMENT, "0 is no kind of command");
    FAILS(sinew_set(client, "left", 99, 0.1, 1.0, NULL), SINEW_ERROR_ARGUMENT, "99 is no kind of command");
    SinewTaken taken = {3, 3.0};
    FAILS(sinew_set(client, "left", SINEW_COMMAND_KIND_DUTY, 0.1, 1.0, odd(&taken)), SINEW_ERROR_ARGUMENT, "taken is at an odd address");

    SinewRefusal refusal;
    FAILS(sinew_set(client, "left", SINEW_COMMAND_KIND_STROKE, 7.0, 1.0, &taken), SINEW_ERROR_REFUSED, "stroke 7 is outside");
    CHECK(taken.cycle == 3 && taken.hold_s == 3.0);
    CHECK(sinew_refusals() == 1 && sinew_refusal(0, &refusal) == SINEW_OK);
    CHECK(strcmp(refusal.channel, "left") == 0 && refusal.kind == SINEW_COMMAND_KIND_STROKE && refusal.value == 7.0);
    CHECK(refusal.outcome == SINEW_OUTCOME_OUT_OF_RANGE && refusal.low < refusal.high && refusal.high < 7.0 && refusal.fault == 0);
    CHECK(isnan(refusal.longest_s) && isnan(refusal.temperature_c) && isnan(refusal.below_c));
    CHECK(strstr(sinew_last_error(), refusal.message) != NULL && strcmp(sinew_last_remedy(), refusal.remedy) == 0);
    FAILS(sinew_refusal(0, NULL), SINEW_ERROR_ARGUMENT, "refusal is null");
    CHECK(sinew_refusals() == 0);
    FAILS(sinew_refusal(0, &refusal), SINEW_ERROR_ARGUMENT, "there is no refusal 0");

    /* Several at once: all or none. */
    SinewWanted pose[65];
    for (uint32_t i = 0; i < 65; i++) {
        pose[i].channel = i;
        pose[i].kind = SINEW_COMMAND_KIND_STROKE;
        pose[i].value = 0.5;
    }
    FAILS(sinew_claim(client, NULL, 2, 5, 1.0, NULL), SINEW_ERROR_ARGUMENT, "channels is null");
    FAILS(sinew_release(client, NULL, SIZE_MAX), SINEW_ERROR_CHANNELS, "a rig has 1 to 64 channels");
    FAILS(sinew_set_many(client, NULL, 2, 1.0, NULL), SINEW_ERROR_ARGUMENT, "wanted is null");
    FAILS(sinew_set_many(client, pose, 0, 1.0, NULL), SINEW_ERROR_CHANNELS, "a rig has 1 to 64 channels");
    FAILS(sinew_set_many(client, pose, 65, 1.0, NULL), SINEW_ERROR_CHANNELS, "a rig has 1 to 64 channels");
    FAILS(sinew_set_many(client, pose, (size_t)1 << 40, 1.0, NULL), SINEW_ERROR_CHANNELS, "a rig has 1 to 64 channels");
    FAILS(sinew_set_many(client, pose, SIZE_MAX, 1.0, NULL), SINEW_ERROR_CHANNELS, "a rig has 1 to 64 channels");
    FAILS(sinew_set_many(client, odd(pose), 2, 1.0, NULL), SINEW_ERROR_ARGUMENT, "wanted is at an odd address");
    FAILS(sinew_set_many(client, pose, 3, 1.0, NULL), SINEW_ERROR_REFUSED_TOGETHER, "nothing of the request was carried out");
    CHECK(sinew_refusals() == 1 && sinew_refusal(0, &refusal) == SINEW_OK && refusal.outcome == SINEW_OUTCOME_UNKNOWN_CHANNEL);
    pose[1].channel = 0;
    FAILS(sinew_set_many(client, pose, 2, 1.0, NULL), SINEW_ERROR_REFUSED_TOGETHER, "left stands twice in the request");
    pose[1].channel = 1;
    pose[1].value = NAN;
    FAILS(sinew_set_many(client, pose, 2, 1.0, NULL), SINEW_ERROR_REFUSED_TOGETHER, "right: stroke or hold is not a finite number");
    CHECK(sinew_refusals() == 1 && sinew_refusal(0, &refusal) == SINEW_OK && strcmp(refusal.channel, "right") == 0);
    pose[1].kind = 99;
    FAILS(sinew_set_many(client, pose, 2, 1.0, NULL), SINEW_ERROR_ARGUMENT, "99 is no kind of command");
    pose[1].kind = SINEW_COMMAND_KIND_RESET;
    pose[1].value = 0.0;
    FAILS(sinew_set_many(client, pose, 2, 1.0, NULL), SINEW_ERROR_REFUSED_TOGETHER, "reset has to be asked for alone");
    FAILS(sinew_set_many(client, pose, 1, NAN, NULL), SINEW_ERROR_ARGUMENT, "hold_s = NaN is no time");

    /* None of it was carried out. */
    CHECK(sinew_latest(client, &snapshot) == SINEW_OK);
    CHECK(snapshot.channel[0].mode == SINEW_MODE_OFF && snapshot.channel[1].mode == SINEW_MODE_OFF);
}

static SinewCycleStream *shared = NULL;

static void *read_on(void *nothing) {
    static SinewCycle own;
    SinewStatus status;
    do {
        status = sinew_stream_next(shared, 60.0, &own);
    } while (status == SINEW_OK || status == SINEW_ERROR_IN_USE);
    CHECK(status == SINEW_ERROR_HANDLE);
    return nothing;
}

static void *wait_on(void *client) {
    SinewStatus status;
    do {
        status = sinew_wait((const SinewClient *)client, 60.0);
    } while (status == SINEW_OK);
    FAILS(status, SINEW_ERROR_HANDLE, "this is no open client");
    return NULL;
}

/* One stream for two threads, and handles that are closed while they are used. */
static void sharing(SinewClient *client) {
    pthread_t threads[3];
    CHECK(sinew_stream(client, &shared) == SINEW_OK);
    CHECK(pthread_create(&threads[0], NULL, read_on, NULL) == 0);
    CHECK(pthread_create(&threads[1], NULL, wait_on, client) == 0);
    CHECK(pthread_create(&threads[2], NULL, wait_on, client) == 0);
    SinewStatus status;
    do {
        status = sinew_stream_counts(shared, NULL, NULL);
        CHECK(status == SINEW_OK || status == SINEW_ERROR_IN_USE);
    } while (status == SINEW_OK);
    CHECK(strstr(sinew_last_error(), "another thread is using this stream; open a stream for each thread") != NULL);
    CHECK(sinew_stream_close(shared) == SINEW_OK);
    CHECK(sinew_close(client) == SINEW_OK);
    for (int i = 0; i < 3; i++) {
        CHECK(pthread_join(threads[i], NULL) == 0);
    }
    /* The words are this thread's own still. */
    CHECK(strstr(sinew_last_error(), "another thread is using this stream") != NULL);
    FAILS(sinew_latest(client, &snapshot), SINEW_ERROR_HANDLE, "use a client only between opening and closing it");
    FAILS(sinew_all_off(client), SINEW_ERROR_HANDLE, "this is no open client");
    FAILS(sinew_close(client), SINEW_ERROR_HANDLE, "close it once");
}

/* A forked process cannot use what it inherits, nor close it under the one before; it connects anew. */
static void forking(const char *rig, SinewClient *client) {
    SinewCycleStream *stream = NULL;
    CHECK(sinew_stream(client, &stream) == SINEW_OK);
    const pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        SinewClient *own = NULL;
        FAILS(sinew_all_off(client), SINEW_ERROR_HANDLE, "connect anew after fork");
        FAILS(sinew_stream_next(stream, 0.0, &cycle), SINEW_ERROR_HANDLE, "this stream was opened by the process that this one was forked from");
        FAILS(sinew_close(client), SINEW_ERROR_HANDLE, "connect anew after fork");
        CHECK(sinew_connect(rig, &own) == SINEW_OK);
        CHECK(sinew_all_off(own) == SINEW_OK && sinew_wait(own, 60.0) == SINEW_OK && sinew_close(own) == SINEW_OK);
        /* Not exit: valgrind would take what is the process before's for leaks of this one. */
        execlp("true", "true", (char *)NULL);
        exit(1);
    }
    int ended = -1;
    CHECK(waitpid(child, &ended, 0) == child && WIFEXITED(ended) && WEXITSTATUS(ended) == 0);
    CHECK(sinew_all_off(client) == SINEW_OK && sinew_stream_next(stream, 60.0, &cycle) == SINEW_OK);
    CHECK(sinew_stream_close(stream) == SINEW_OK);
}

int main(int count, char **arguments) {
    CHECK(count == 2);
    SinewClient *client = NULL;
    connecting();
    clocks();
    CHECK(sinew_connect(arguments[1], &client) == SINEW_OK);
    reading(client);
    commanding(client);
    forking(arguments[1], client);
    sharing(client);
    puts("refused all");
    return 0;
}
