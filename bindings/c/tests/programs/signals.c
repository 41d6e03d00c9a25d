/*
 * Every call that waits or asks, while a timer's signal interrupts whatever the system is doing for this program two thousand times a second:
 * `signals RIG`, with the channel left.
 */
#define _XOPEN_SOURCE 700

#include "check.h"

#include <signal.h>
#include <sys/time.h>

static volatile sig_atomic_t rung = 0;

static void ring(int number) {
    (void)number;
    rung++;
}

int main(int count, char **arguments) {
    CHECK(count == 2);
    struct sigaction action;
    memset(&action, 0, sizeof action);
    /* Without SA_RESTART: system calls come back unfinished. */
    action.sa_handler = ring;
    CHECK(sigaction(SIGALRM, &action, NULL) == 0);
    const struct itimerval often = {{0, 500}, {0, 500}};
    CHECK(setitimer(ITIMER_REAL, &often, NULL) == 0);

    static SinewSnapshot snapshot;
    static SinewCycle cycle;
    size_t found = 0;
    for (int round = 0; round < 20; round++) {
        SinewClient *client = NULL;
        SinewCycleStream *stream = NULL;
        SinewFaultWatch *faults = NULL;
        SinewFaultChange change;
        CHECK(sinew_discover(NULL, 0, &found) == SINEW_OK && found >= 1);
        CHECK(sinew_connect(arguments[1], &client) == SINEW_OK);
        CHECK(sinew_stream(client, &stream) == SINEW_OK);
        CHECK(sinew_faults(client, &faults) == SINEW_OK);
        CHECK(sinew_rig_text(client, NULL, 0, &found) == SINEW_OK && found > 0);
        for (int call = 0; call < 20; call++) {
            CHECK(sinew_set_stroke(client, "left", 0.1, 60.0) == SINEW_OK);
            CHECK(sinew_wait(client, 60.0) == SINEW_OK);
            CHECK(sinew_stream_next(stream, 60.0, &cycle) == SINEW_OK);
            CHECK(sinew_latest(client, &snapshot) == SINEW_OK && snapshot.channel[0].mode == SINEW_MODE_LENGTH);
        }
        CHECK(sinew_faults_next(faults, 0.05, &change) == SINEW_NOTHING);
        CHECK(sinew_all_off(client) == SINEW_OK);
        CHECK(sinew_stream_close(stream) == SINEW_OK && sinew_faults_close(faults) == SINEW_OK && sinew_close(client) == SINEW_OK);
    }
    CHECK(rung > 100);
    puts("not disturbed");
    return 0;
}
