/* Frame identity: new, duplicate, conflict, and names from the wire. */
#include <stdio.h>
#include <string.h>

#include "assert_close.h"

#include <toliman/track.h>

static int32_t verdict_of(toliman_track *track, const char *session, int64_t id, const char *roi, const char *bytes) {
    int32_t verdict = -1;
    assert_ok(toliman_track_push(track, session, id, roi, bytes, strlen(bytes), &verdict));
    return verdict;
}

static void keys_and_contents(void **unused) {
    (void)unused;
    toliman_track *track = NULL;
    assert_ok(toliman_track_create(100, &track));
    assert_int_equal(verdict_of(track, "s1", 7, "core", "pixels"), TOLIMAN_TRACK_NEW);
    assert_int_equal(verdict_of(track, "s1", 7, "core", "pixels"), TOLIMAN_TRACK_DUPLICATE);
    assert_int_equal(verdict_of(track, "s1", 7, "corner", "pixels"), TOLIMAN_TRACK_NEW);
    assert_int_equal(verdict_of(track, "s2", 7, "core", "pixels"), TOLIMAN_TRACK_NEW);
    assert_int_equal(verdict_of(track, "s1", 8, "core", "pixels"), TOLIMAN_TRACK_NEW);
    assert_int_equal(verdict_of(track, "s1", -7, "core", "pixels"), TOLIMAN_TRACK_NEW);
    assert_int_equal(verdict_of(track, "s1", 8, "core", "pixelz"), TOLIMAN_TRACK_CONFLICT);
    assert_int_equal(verdict_of(track, "s1", 8, "core", "pixels"), TOLIMAN_TRACK_CONFLICT);
    assert_int_equal(verdict_of(track, "s1", 7, "core", "pixels"), TOLIMAN_TRACK_DUPLICATE);
    assert_int_equal(toliman_track_count(track), 5);
    toliman_track_destroy(track);
    toliman_track_destroy(NULL);
}

static void full_index_keeps_what_it_has(void **unused) {
    (void)unused;
    toliman_track *track = NULL;
    enum { CAPACITY = 5000 };
    assert_ok(toliman_track_create(CAPACITY, &track));
    for (int64_t id = 0; id < CAPACITY; id++)
        assert_int_equal(verdict_of(track, "pass", id, "core", "x"), TOLIMAN_TRACK_NEW);
    int32_t verdict = -1;
    assert_fails(toliman_track_push(track, "pass", CAPACITY, "core", "x", 1, &verdict), TOLIMAN_E_CAPACITY, "5000");
    assert_int_equal(verdict, -1);
    for (int64_t id = 0; id < CAPACITY; id++)
        assert_int_equal(verdict_of(track, "pass", id, "core", "x"), TOLIMAN_TRACK_DUPLICATE);
    assert_int_equal(toliman_track_count(track), CAPACITY);
    toliman_track_destroy(track);
}

static void names_from_the_wire(void **unused) {
    (void)unused;
    static const char *const bad[] = {
        "",    ".hidden", "../up",       "a/b",
        "a b", "a\n",     "caf\xc3\xa9", "0123456789012345678901234567890123456789012345678901234567890123456789"};
    toliman_track *track = NULL;
    int32_t verdict;
    assert_fails(toliman_track_create(0, &track), TOLIMAN_E_ARGUMENT, "capacity = 0");
    assert_ok(toliman_track_create(4, &track));
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_fails(toliman_track_push(track, bad[i], 1, "core", "x", 1, &verdict), TOLIMAN_E_ARGUMENT, "session");
        assert_fails(toliman_track_push(track, "s", 1, bad[i], "x", 1, &verdict), TOLIMAN_E_ARGUMENT, "roi");
    }
    assert_fails(toliman_track_push(track, NULL, 1, "core", "x", 1, &verdict), TOLIMAN_E_ARGUMENT, "session is NULL");
    assert_int_equal(toliman_track_count(track), 0);
    toliman_track_destroy(track);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_and_contents),
        cmocka_unit_test(full_index_keeps_what_it_has),
        cmocka_unit_test(names_from_the_wire),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
