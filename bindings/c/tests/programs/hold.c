/* Renews a setpoint without a pause, to be killed in the middle: `hold RIG CHANNEL STROKE HOLD_S`; says `holding` once it has been taken. */
#include "check.h"

int main(int count, char **arguments) {
    CHECK(count == 5);
    SinewClient *client = NULL;
    CHECK(sinew_connect(arguments[1], &client) == SINEW_OK);
    for (int is_first = 1;; is_first = 0) {
        CHECK(sinew_set_stroke(client, arguments[2], strtod(arguments[3], NULL), strtod(arguments[4], NULL)) == SINEW_OK);
        if (is_first) {
            puts("holding");
            fflush(stdout);
        }
    }
}
