/* Tests scalar random numbers: the published vectors of the generator, its counters, and the normal distribution. */
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"

void shim_bits(uint64_t seed, uint32_t stream, size_t count, uint64_t *bits);
void shim_uniforms(uint64_t seed, uint32_t stream, size_t count, double *uniforms);
void shim_normals(uint64_t seed, uint32_t stream, size_t count, double *normals);
void shim_random123(const uint32_t counter[4], const uint32_t key[2], uint32_t words[4]);

/* Test vectors published with the generator (Random123, kat_vectors, philox4x32 10). */
static void philox_gives_the_published_words(void **state) {
    static const uint32_t known[3][10] = {
        {0, 0, 0, 0, 0, 0, 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8},
        {0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0x408f276d, 0x41c83b0e, 0xa20bc7c6,
         0x6d5451fd},
        {0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344, 0xa4093822, 0x299f31d0, 0xd16cfe09, 0x94fdcceb, 0x5001e420,
         0x24126ea1},
    };
    for (size_t i = 0; i < 3; i++) {
        uint32_t words[4];
        shim_random123(known[i], known[i] + 4, words);
        assert_memory_equal(words, known[i] + 6, sizeof words);
    }
}

static void sequence_counts_blocks_of_its_stream(void **state) {
    const uint64_t seed = 0x0123456789abcdef;
    const uint32_t stream = 2, key[2] = {0x89abcdef, 0x01234567};
    uint64_t bits[10];
    shim_bits(seed, stream, 10, bits);
    for (uint32_t block = 0; block < 5; block++) {
        const uint32_t counter[4] = {block, stream << 16, 0, 0};
        uint32_t words[4];
        shim_random123(counter, key, words);
        assert_true(bits[2 * block] == (words[0] | (uint64_t)words[1] << 32));
        assert_true(bits[2 * block + 1] == (words[2] | (uint64_t)words[3] << 32));
    }
}

static void uniforms_stay_inside_and_are_even(void **state) {
    enum { count = 1000000 };
    double *uniforms = malloc(count * sizeof *uniforms);
    shim_uniforms(11, 0, count, uniforms);
    double sum = 0;
    size_t tenths[10] = {0};
    for (size_t i = 0; i < count; i++) {
        assert_true(uniforms[i] > 0 && uniforms[i] < 1);
        sum += uniforms[i];
        tenths[(size_t)(10 * uniforms[i])]++;
    }
    assert_close(sum / count, 0.5, 0, 4 * sqrt(1.0 / 12 / count));
    for (size_t i = 0; i < 10; i++)
        assert_close((double)tenths[i], 0.1 * count, 0, 4 * sqrt(0.09 * count));
    free(uniforms);
}

static void normals_have_the_moments_and_tails(void **state) {
    enum { count = 1000000 };
    double *normals = malloc(count * sizeof *normals);
    shim_normals(7, 2, count, normals);
    double first = 0, second = 0, fourth = 0, neighbours = 0, beyond_3 = 0;
    for (size_t i = 0; i < count; i++) {
        const double square = normals[i] * normals[i];
        first += normals[i];
        second += square;
        fourth += square * square;
        neighbours += normals[i] * normals[(i + 1) % count];
        beyond_3 += square > 9;
    }
    const double expected_3 = count * erfc(3 / sqrt(2));
    assert_close(first / count, 0, 0, 4 / sqrt(count));
    assert_close(second / count, 1, 0, 4 * sqrt(2.0 / count));
    assert_close(fourth / count, 3, 0, 4 * sqrt(96.0 / count));
    assert_close(neighbours / count, 0, 0, 4 / sqrt(count));
    assert_close(beyond_3, expected_3, 0, 4 * sqrt(expected_3));
    free(normals);
}

static void sequences_differ_by_seed_and_stream(void **state) {
    uint64_t base[64], other[64];
    const uint64_t seeds[] = {2, 1 + (UINT64_C(1) << 32), 1};
    const uint32_t streams[] = {0, 0, 1};
    shim_bits(1, 0, 64, base);
    for (size_t k = 0; k < 3; k++) {
        shim_bits(seeds[k], streams[k], 64, other);
        for (size_t i = 0; i < 64; i++)
            assert_true(base[i] != other[i]);
    }
    shim_bits(1, 0, 64, other);
    assert_memory_equal(base, other, sizeof base);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(philox_gives_the_published_words),    cmocka_unit_test(sequence_counts_blocks_of_its_stream),
        cmocka_unit_test(uniforms_stay_inside_and_are_even),   cmocka_unit_test(normals_have_the_moments_and_tails),
        cmocka_unit_test(sequences_differ_by_seed_and_stream),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
