/* Frame identity: new, duplicate, conflict, and names from the wire. */
#include <malloc.h>
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

/* Contents of one key are told apart by CRC32 and by size, each of which may agree alone. */
static void contents_of_other_sizes(void **unused) {
    (void)unused;
    /* CRC32 98ad1158 and 0073f864, whose mixtures with 64 and 60 times the golden ratio agree. */
    unsigned char longer[64], shorter[60];
    memset(longer, 7, sizeof longer);
    memset(shorter, 7, sizeof shorter);
    memcpy(longer, "\xcb\x38\x03\x00", 4);
    memcpy(shorter, "\xc2\x6b\x00\x00", 4);
    /* Four bytes that end a text so that its CRC32 is that of the empty text, 0. */
    const char *const nothing = "", *const four = "\x9d\x0a\xd9\x6d";
    toliman_track *track = NULL;
    int32_t verdict = -1;
    assert_ok(toliman_track_create(4, &track));
    assert_ok(toliman_track_push(track, "s", 1, "roi", longer, sizeof longer, &verdict));
    assert_ok(toliman_track_push(track, "s", 1, "roi", shorter, sizeof shorter, &verdict));
    assert_int_equal(verdict, TOLIMAN_TRACK_CONFLICT);
    assert_ok(toliman_track_push(track, "s", 2, "roi", nothing, 0, &verdict));
    assert_int_equal(verdict, TOLIMAN_TRACK_NEW);
    assert_ok(toliman_track_push(track, "s", 2, "roi", four, 4, &verdict));
    assert_int_equal(verdict, TOLIMAN_TRACK_CONFLICT);
    toliman_track_destroy(track);
}

/* 36 bytes a frame for any capacity, not only for powers of two. */
static void memory_of_an_index(void **unused) {
    (void)unused;
    const int64_t capacities[] = {1 << 20, (1 << 20) + 1, 1500000};
    for (size_t i = 0; i < sizeof capacities / sizeof *capacities; i++) {
        toliman_track *track = NULL;
        const struct mallinfo2 before = mallinfo2();
        assert_ok(toliman_track_create(capacities[i], &track));
        const struct mallinfo2 after = mallinfo2();
        const size_t taken = after.uordblks + after.hblkhd - before.uordblks - before.hblkhd;
        assert_at_most((double)taken / (double)capacities[i], 36.1);
        toliman_track_destroy(track);
    }
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
        cmocka_unit_test(keys_and_contents),       cmocka_unit_test(full_index_keeps_what_it_has),
        cmocka_unit_test(contents_of_other_sizes), cmocka_unit_test(memory_of_an_index),
        cmocka_unit_test(names_from_the_wire),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
