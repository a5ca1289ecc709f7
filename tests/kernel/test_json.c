/* Tests that the numbers of a JSON tree keep their own exact integers; unit/test_ingest tests which are integers. */
#include <inttypes.h>
#include <stdbool.h>

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
        cmocka_unit_test(integers_of_a_tree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
