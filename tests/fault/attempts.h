/* Calls of scenarios, and the comparison of their results with those of an undisturbed call. */
#ifndef TOLIMAN_TESTS_ATTEMPTS_H
#define TOLIMAN_TESTS_ATTEMPTS_H

#include "failing.h"
#include "scenario.h"

enum { MOST_THREADS = 8 };

/* The current scenario and failure, for messages. */
extern const scenario *now;
extern char failure[120];
extern int defects;
void complain(const char *when, const char *what, toliman_status status);

/* A call without failures, and its expected results. */
typedef struct {
    uint64_t before, after, made;
    long calls;       /* number of calls that can fail */
    saved_file saved; /* of a call that saves */
} reference;

reference undisturbed_call(enum what what);
void end_of_calls(reference *good);
/* Of the outputs, objects and file of the last undisturbed call. */
uint64_t digest_of_reference(const reference *good);

/* Prepares files, object and outputs of a call; begin_in for one of the threads and, unless NULL, a given object. */
void begin(attempt *a);
void begin_in(attempt *a, int thread, void *object);
void end(attempt *a);

/* Compares the results of a successful call with those of the undisturbed call. */
void compare(const attempt *a, const reference *good, const char *when);
void check_files(attempt *a, const reference *good, toliman_status status);
int created_something(const attempt *a);
int is_unmodified(const attempt *a, const reference *good);
int is_untouched(const attempt *a);
void clear_outputs(attempt *a);

#endif
