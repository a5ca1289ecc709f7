/* Tests the nearest word against a recursive edit distance, for all pairs of short words, and its limits. */
#include <stdbool.h>
#include <string.h>

#include "assert_close.h"

void shim_nearest_word(const char *word, const char *const *candidates, size_t count, char *nearest);

/* By the definition: the first letters are equal, or one of the three edits is made. */
static size_t distance(const char *a, const char *b) {
    if (*a == '\0' || *b == '\0')
        return strlen(a) + strlen(b);
    if (*a == *b)
        return distance(a + 1, b + 1);
    const size_t replaced = distance(a + 1, b + 1), removed = distance(a + 1, b), added = distance(a, b + 1);
    const size_t least = removed < added ? removed : added;
    return 1 + (replaced < least ? replaced : least);
}

TEST(distances_of_short_words) {
    enum { LETTERS = 3, LENGTH = 6, WORDS = 729 };
    char a[LENGTH + 1] = "", b[LENGTH + 1] = "", nearest[LENGTH + 1];
    int near = 0;
    for (int i = 0; i < WORDS; i += 7)
        for (int j = 0; j < WORDS; j++) {
            for (int k = 0, x = i, y = j; k < LENGTH; k++, x /= LETTERS, y /= LETTERS) {
                a[k] = (char)('a' + x % LETTERS);
                b[k] = (char)('a' + y % LETTERS);
            }
            b[1 + j % LENGTH] = '\0';
            const char *const candidates[] = {b};
            shim_nearest_word(a, candidates, 1, nearest);
            const size_t edits = distance(a, b);
            const bool found = edits <= 2 && edits < strlen(b);
            assert_string_equal(nearest, found ? b : "");
            near += found;
        }
    assert_in_range(near, 1000, WORDS * 105 - 1000);
}

static void assert_nearest(const char *word, const char *expected) {
    const char *const words[] = {"gain_e_per_dn", "full_well_e", "full_well", "bit_depth", "A", "qe", ""};
    char nearest[40];
    shim_nearest_word(word, words, sizeof words / sizeof *words, nearest);
    assert_string_equal(nearest, expected);
}

TEST(limits) {
    assert_nearest("full_well_a", "full_well_e");    /* 1 edit, and 2 from full_well */
    assert_nearest("full_well_", "full_well_e");     /* 1 edit from both: the first */
    assert_nearest("gain_dn", "");                   /* 6 edits */
    assert_nearest("gain_per_adu", "gain_e_per_dn"); /* 4 edits of 12 letters */
    assert_nearest("gain_per_adus", "");             /* 5 edits of 13 letters */
    assert_nearest("gain_e_per_count", "gain_e_per_dn");
    assert_nearest("B", ""); /* no letter in common */
    assert_nearest("qa", "qe");
    assert_nearest("", "");
    char word[66];
    memset(word, 'x', sizeof word - 1);
    memcpy(word, "full_well_e", 11);
    word[65] = '\0';
    assert_nearest(word, "");
}

RUN_TESTS(NULL, NULL)
