/* Tests that integers of JSON text are exact, and which numbers are integers. */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>

#include "assert_close.h"

double shim_json_number(const char *text, const char *path);
bool shim_json_integer(const char *text, const char *path, int64_t *integer);

static void assert_integer(const char *text, const char *path, int64_t expected) {
    int64_t found;
    assert_true(shim_json_integer(text, path, &found));
    if (found != expected)
        fail_msg("%s, %s: %" PRId64 " instead of %" PRId64, text, path, found, expected);
}

static void assert_no_integer(const char *text, const char *path, double expected) {
    int64_t found;
    assert_false(shim_json_integer(text, path, &found));
    assert_true(shim_json_number(text, path) == expected);
}

/* printf of int64_t is the reference; a double carries 53 bits only. */
static void integers_are_exact(void **state) {
    const int64_t integers[] = {0,
                                1,
                                -1,
                                1000000,
                                INT64_C(9007199254740992),
                                INT64_C(9007199254740993),
                                INT64_C(-9007199254740993),
                                INT64_MAX,
                                INT64_MIN};
    for (size_t i = 0; i < sizeof integers / sizeof *integers; i++) {
        char text[40];
        snprintf(text, sizeof text, " %" PRId64 "\n", integers[i]);
        assert_integer(text, "", integers[i]);
        assert_true(shim_json_number(text, "") == (double)integers[i]);
    }
    assert_integer("-0", "", 0);
    assert_true(signbit(shim_json_number("-0", "")));
}

static void other_numbers_have_no_integer(void **state) {
    assert_no_integer("1e3", "", 1000);
    assert_no_integer("1E+2", "", 100);
    assert_no_integer("1.0", "", 1);
    assert_no_integer("0.5", "", 0.5);
    assert_no_integer("9223372036854775808", "", 9223372036854775808.0);
    assert_no_integer("-9223372036854775809", "", -9223372036854775808.0);
    assert_no_integer("\"12\"", "", 0);
    assert_no_integer("true", "", 0);
}

/* Numbers among strings, keys that look like numbers, escapes and nested arrays keep their integers. */
static void integers_of_a_tree(void **state) {
    const char *const text =
        "\xef\xbb\xbf{\"1\": [2, \"3\", 4.5, [], {\"a\\\"5\": -6}], \"7,8\": {\"b\": [true, 9, null]}, "
        "\"c\": 10}";
    assert_integer(text, "00", 2);
    assert_no_integer(text, "01", 0);
    assert_no_integer(text, "02", 4.5);
    assert_integer(text, "040", -6);
    assert_integer(text, "101", 9);
    assert_integer(text, "2", 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integers_are_exact),
        cmocka_unit_test(other_numbers_have_no_integer),
        cmocka_unit_test(integers_of_a_tree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
