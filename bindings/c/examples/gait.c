/*
 * A robot program in C: walks the built-in hexapod with a tripod gait, as examples/gait.rs does.
 *
 *     sinew run                                                       in one terminal: the driver, on simulated wires
 *     cc gait.c $(pkg-config --cflags --libs sinew) -lm -o gait       in another
 *     ./gait            or  ./gait RIG 30                             another rig of the same legs, for 30 s
 *
 * Six legs of three wires. The legs of a tripod move together, the two tripods in turn: while one steps, the other carries. A wire contracts within
 * a second when heated but takes two or three to cool and stretch again, so what needs cooling gets more time.
 */
#define _POSIX_C_SOURCE 200809L

#include <sinew.h>

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LEGS = 6, JOINTS = 3, WIRES = LEGS * JOINTS };

/* Half a gait cycle: one tripod's step. */
static const double step_s = 4.0;
/* How often setpoints are sent, all of them in one request. */
static const double tick_s = 0.02;
/* How long each holds: if this program hangs or dies, the wires go off this much later. */
static const double lease_s = 0.5;

/* Ctrl-C and SIGTERM only raise a flag: this program ends where it knows what state it is in. */
static volatile sig_atomic_t interrupted = 0;

static void interrupt(int number) {
    (void)number;
    interrupted = 1;
}

static double now_s(void) {
    return 1e-9 * (double)sinew_monotonic_ns();
}

static void sleep_s(double seconds) {
    if (seconds > 0.0) {
        struct timespec time;
        time.tv_sec = (time_t)seconds;
        time.tv_nsec = (long)(1e9 * (seconds - (double)time.tv_sec));
        nanosleep(&time, NULL);
    }
}

/* From 0 to 1 between two times, without a jerk at either end. */
static double ramp(double t, double from, double to) {
    const double x = fmin(fmax((t - from) / (to - from), 0.0), 1.0);
    return x * x * (3.0 - 2.0 * x);
}

/* Strokes of coxa, femur and tibia, 0 = cold and long, so long into the leg's own cycle, which begins with its step. */
static void strokes(double t_s, double out[JOINTS]) {
    const double t = fmod(t_s, 2.0 * step_s);
    const double lifted = ramp(t, 0.0, 1.0) - ramp(t, 2.0, 4.0);
    /* Forward in the air, back on the ground: that pushes the body forward. */
    const double forward = ramp(t, 1.0, 2.0) - ramp(t, step_s, 2.0 * step_s);
    out[0] = 0.15 + 0.45 * forward;
    out[1] = 0.15 + 0.45 * lifted;
    out[2] = 0.20 + 0.25 * forward;
}

/* The wires by their names in the rig file, a leg after the other: their numbers in the driver. */
static SinewStatus find_wires(const SinewClient *client, uint32_t wires[WIRES]) {
    static const char *const places[] = {"front_left", "front_right", "middle_left", "middle_right", "rear_left", "rear_right"};
    static const char *const joints[] = {"coxa", "femur", "tibia"};
    for (int wire = 0; wire < WIRES; wire++) {
        char name[SINEW_NAME_SIZE];
        snprintf(name, sizeof name, "%s_%s", places[wire / JOINTS], joints[wire % JOINTS]);
        const SinewStatus status = sinew_channel(client, name, &wires[wire]);
        if (status != SINEW_OK) {
            return status;
        }
    }
    return SINEW_OK;
}

/* Sends a pose. Wires the driver refuses are told about and left out; the others walk on. */
static SinewStatus send_pose(const SinewClient *client, const SinewChannelInfo *channels, SinewWanted *pose) {
    SinewStatus status = sinew_set_many(client, pose, WIRES, lease_s, NULL);
    if (status != SINEW_ERROR_REFUSED_TOGETHER) {
        return status;
    }
    size_t left = WIRES;
    SinewRefusal refusal;
    for (size_t i = 0; i < sinew_refusals() && sinew_refusal(i, &refusal) == SINEW_OK; i++) {
        fprintf(stderr, "%s; %s\n", refusal.message, refusal.remedy);
        for (size_t wire = 0; wire < left; wire++) {
            if (strcmp(channels[pose[wire].channel].name, refusal.channel) == 0) {
                pose[wire] = pose[--left];
                break;
            }
        }
    }
    status = sinew_set_many(client, pose, left, lease_s, NULL);
    /* None is left, or one more has failed meanwhile: the next pose comes soon. */
    return status == SINEW_ERROR_CHANNELS || status == SINEW_ERROR_REFUSED_TOGETHER ? SINEW_OK : status;
}

static SinewStatus walk(const SinewClient *client, const uint32_t wires[WIRES], const SinewChannelInfo *channels, double end_s,
                        SinewCycleStream *stream, SinewFaultWatch *faults) {
    const double start = now_s();
    double next = start, next_line = 1.0, squares = 0.0, lengths = 0.0;
    static SinewCycle cycle;
    SinewStatus status = SINEW_OK;
    while (!interrupted && now_s() - start < end_s) {
        const double t = now_s() - start;

        /* Command every wire, all in the same cycle. */
        SinewWanted pose[WIRES];
        for (int leg = 0; leg < LEGS; leg++) {
            const int tripod = (leg / 2 + leg % 2) % 2;
            double stroke[JOINTS];
            strokes(t + step_s * tripod, stroke);
            for (int joint = 0; joint < JOINTS; joint++) {
                SinewWanted *const wanted = &pose[leg * JOINTS + joint];
                wanted->channel = wires[leg * JOINTS + joint];
                wanted->kind = SINEW_COMMAND_KIND_STROKE;
                wanted->value = stroke[joint];
            }
        }
        status = send_pose(client, channels, pose);
        if (status < 0) {
            return status;
        }

        /* See what became of it: every cycle since the last look, not only the latest. */
        while ((status = sinew_stream_next(stream, 0.0, &cycle)) == SINEW_OK) {
            for (uint32_t channel = 0; channel < cycle.channels; channel++) {
                const double error_m = cycle.channel[channel].length_m - cycle.channel[channel].target_m;
                /* NaN while a wire has no length or no target. */
                if (!isnan(error_m)) {
                    squares += error_m * error_m;
                    lengths += 1.0;
                }
            }
        }
        if (status < 0) {
            return status;
        }
        SinewFaultChange change;
        while ((status = sinew_faults_next(faults, 0.0, &change)) == SINEW_OK) {
            const char *const what = change.after ? sinew_fault_cause(change.after) : "fault cleared";
            fprintf(stderr, "%s: %s; %s\n", channels[change.channel].name, what, sinew_fault_remedy(change.after));
        }
        if (status < 0) {
            return status;
        }

        if (now_s() - start >= next_line) {
            uint64_t lost = 0;
            sinew_stream_counts(stream, NULL, &lost);
            printf("%6.1f s  rms error %.3f mm  lost cycles %llu\n", t, 1e3 * sqrt(squares / lengths), (unsigned long long)lost);
            fflush(stdout);
            squares = lengths = 0.0;
            next_line += 1.0;
        }
        next += tick_s;
        sleep_s(next - now_s());
    }
    return SINEW_OK;
}

int main(int count, char **arguments) {
    const char *const rig = count > 1 ? arguments[1] : "hexapod";
    const double end_s = count > 2 ? strtod(arguments[2], NULL) : INFINITY;
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = interrupt;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);

    SinewClient *client = NULL;
    SinewCycleStream *stream = NULL;
    SinewFaultWatch *faults = NULL;
    static SinewChannelInfo channels[SINEW_MAX_CHANNELS];
    uint32_t wires[WIRES];
    size_t found = 0;

    SinewStatus status = sinew_connect(rig, &client);
    if (status == SINEW_OK) status = sinew_channels(client, channels, SINEW_MAX_CHANNELS, &found);
    if (status == SINEW_OK) status = find_wires(client, wires);
    if (status == SINEW_OK) status = sinew_stream(client, &stream);
    if (status == SINEW_OK) status = sinew_faults(client, &faults);
    if (status == SINEW_OK) {
        printf("walking %s: %zu channels\n", rig, found);
        fflush(stdout);
        status = walk(client, wires, channels, end_s, stream, faults);
        if (status < 0) {
            fprintf(stderr, "gait: %s\n", sinew_last_error());
        }
        /* Whatever has happened: hand the wires back cold. Were this program killed instead, their leases would see to it. */
        const SinewStatus off = sinew_all_off(client);
        if (off == SINEW_OK) {
            printf("all channels off\n");
        } else if (status == SINEW_OK) {
            status = off;
            fprintf(stderr, "gait: %s\n", sinew_last_error());
        }
    } else {
        /* The text of an error ends with what to do about it. */
        fprintf(stderr, "gait: %s\n", sinew_last_error());
    }
    sinew_faults_close(faults);
    sinew_stream_close(stream);
    sinew_close(client);
    return status == SINEW_OK ? EXIT_SUCCESS : EXIT_FAILURE;
}
