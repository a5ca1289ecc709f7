/* Tests callers built with an older or newer header: their options may be shorter or longer than the library's. */
#include <stdio.h>
#include <string.h>

#include <toliman/toliman.h>

#include "assert_close.h"

static unsigned char bytes[1024];

/* Options larger than the library's are refused, because it would have to ignore their additional members. */
static void newer_options_are_refused(void **state) {
    (void)state;
    toliman_period *period = NULL;
    const uint32_t size = sizeof(toliman_period_options) + 8;
    memcpy(bytes, &size, sizeof size);
    char message[100];
    snprintf(message, sizeof message, "options->struct_size = %u: must be in [%u, %u]", size, size - 8, size - 8);
    assert_fails(toliman_period_create(0, 0.1, 3, (const void *)bytes, &period), TOLIMAN_E_ARGUMENT, message);
    assert_null(period);
}

static void sizes_by_name(void **state) {
    (void)state;
    assert_int_equal(toliman_get_struct_size("toliman_machine"), sizeof(toliman_machine));
    assert_int_equal(toliman_get_struct_size("toliman_track_stream"), sizeof(toliman_track_stream));
    assert_int_equal(toliman_get_struct_size("toliman_mach"), 0);
    assert_int_equal(toliman_get_struct_size(NULL), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(newer_options_are_refused),
        cmocka_unit_test(sizes_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
