/* For the programs beside it: a check that ends the program and says where, and what the library said last. */
#ifndef CHECK_H
#define CHECK_H

#include <sinew.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                                                          \
    do {                                                                                                          \
        if (!(condition)) {                                                                                       \
            fprintf(stderr, "%s:%d: not so: %s; last error: %s\n", __FILE__, __LINE__, #condition, sinew_last_error()); \
            exit(1);                                                                                              \
        }                                                                                                         \
    } while (0)

/* The call comes to this error, in these words, with a remedy. */
#define FAILS(call, code, words)                                              \
    do {                                                                      \
        const SinewStatus failed_with = (call);                               \
        if (failed_with != (code)) {                                          \
            fprintf(stderr, "%s gives %d\n", #call, (int)failed_with);        \
        }                                                                     \
        CHECK(failed_with == (code));                                         \
        CHECK(strstr(sinew_last_error(), (words)) != NULL);                   \
        CHECK(sinew_last_remedy()[0] != '\0');                                \
        CHECK(strstr(sinew_last_error(), sinew_last_remedy()) != NULL);       \
    } while (0)

#endif
