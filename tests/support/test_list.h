/* The tests of a file, which its main runs in their order. */
#ifndef TOLIMAN_TESTS_TEST_LIST_H
#define TOLIMAN_TESTS_TEST_LIST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

enum { MOST_TESTS = 100 };
static struct CMUnitTest listed_tests[MOST_TESTS];
static int listed_lines[MOST_TESTS];
static size_t listed_count;

static inline void list_test(struct CMUnitTest test, int line) {
    size_t at = listed_count++;
    if (at == MOST_TESTS)
        abort();
    for (; at > 0 && listed_lines[at - 1] > line; at--) {
        listed_tests[at] = listed_tests[at - 1];
        listed_lines[at] = listed_lines[at - 1];
    }
    listed_tests[at] = test;
    listed_lines[at] = line;
}

/* Whether `make long` runs the test. */
static inline int in_long(void) {
    return getenv("TOLIMAN_LONG") != NULL;
}

/* Begin a test, also one with its own set-up and tear-down, and a set-up or tear-down. They do not use the state of
 * CMocka. */
#define TEST_WITH(name, set_up, tear_down)                                                                             \
    static void name(void **);                                                                                         \
    __attribute__((constructor)) static void list_##name(void) {                                                       \
        list_test((struct CMUnitTest){#name, name, set_up, tear_down, NULL}, __LINE__);                                \
    }                                                                                                                  \
    static void name(void **unused_state __attribute__((unused)))
#define TEST(name) TEST_WITH(name, NULL, NULL)
#define FIXTURE(name) static int name(void **unused_state __attribute__((unused)))

/* Runs the tests; and main of a file, with the set-up and tear-down of all tests, or NULL. */
#define RUN_ALL(set_up, tear_down) _cmocka_run_group_tests("tests", listed_tests, listed_count, set_up, tear_down)
#define RUN_TESTS(set_up, tear_down)                                                                                   \
    int main(void) {                                                                                                   \
        return RUN_ALL(set_up, tear_down);                                                                             \
    }

#endif
