/* Tests callers built with an older or newer header: their options may be shorter or longer than the library's. */
#include <string.h>

#include <toliman/toliman.h>

#include "assert_close.h"

static unsigned char bytes[1024];

enum { kFilled = 0xAB };

/* The struct size comes first, and nothing is written beyond `size` bytes. */
static void assert_within(size_t size) {
    uint32_t size_in_struct = 0;
    memcpy(&size_in_struct, bytes, sizeof size_in_struct);
    assert_int_equal(size_in_struct, size);
    for (size_t i = size; i < sizeof bytes; i++)
        assert_int_equal(bytes[i], kFilled);
}

/* An older caller, whose struct lacks the last member, gets today's defaults without it. For a newer caller, members
 * unknown to the library are set to 0. */
#define CHECK_INIT(kind)                                                                                               \
    do {                                                                                                               \
        enum { kSize = sizeof(kind##_options), kHead = sizeof(uint32_t) };                                             \
        kind##_options today;                                                                                          \
        kind##_options_init(&today, sizeof today);                                                                     \
        assert_int_equal(today.struct_size, sizeof today);                                                             \
        for (size_t size = kSize - 8; size <= kSize + 16; size += 8) {                                                 \
            memset(bytes, kFilled, sizeof bytes);                                                                      \
            kind##_options_init((void *)bytes, size);                                                                  \
            assert_within(size);                                                                                       \
            assert_memory_equal(bytes + kHead, (unsigned char *)&today + kHead,                                        \
                                (size < kSize ? size : kSize) - kHead);                                                \
            for (size_t i = kSize; i < size; i++)                                                                      \
                assert_int_equal(bytes[i], 0);                                                                         \
        }                                                                                                              \
        memset(bytes, kFilled, sizeof bytes);                                                                          \
        kind##_options_init((void *)bytes, 0);                                                                         \
        assert_int_equal(bytes[0], kFilled);                                                                           \
        kind##_options_init(NULL, kSize);                                                                              \
    } while (0)

static void defaults_stay_within_their_size(void **state) {
    (void)state;
    CHECK_INIT(toliman_sim);
    CHECK_INIT(toliman_cae);
    CHECK_INIT(toliman_cae_train);
    CHECK_INIT(toliman_cae_save);
    CHECK_INIT(toliman_components);
    CHECK_INIT(toliman_ingest);
    CHECK_INIT(toliman_components_train);
    CHECK_INIT(toliman_mask);
    CHECK_INIT(toliman_period);
    CHECK_INIT(toliman_period_bootstrap);
    CHECK_INIT(toliman_period_batch);
    CHECK_INIT(toliman_period_noise);
    CHECK_INIT(toliman_period_noise_bootstrap);
    CHECK_INIT(toliman_planet);
    CHECK_INIT(toliman_track);
}

/* Options larger than the library's are refused, because it would have to ignore their additional members. */
static void newer_options_are_refused(void **state) {
    (void)state;
    toliman_period *period = NULL;
    toliman_period_options_init((void *)bytes, sizeof(toliman_period_options) + 8);
    assert_fails(toliman_period_create(0, 0.1, 3, (const void *)bytes, &period), TOLIMAN_E_ARGUMENT,
                 "options->struct_size = 240: must be in [72, 232]");
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
        cmocka_unit_test(defaults_stay_within_their_size),
        cmocka_unit_test(newer_options_are_refused),
        cmocka_unit_test(sizes_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
