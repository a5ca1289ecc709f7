/* Tests random numbers: Poisson counts and normal variates of images (generator, elementary functions, rejection
 * envelope, distribution, bits), and scalar ones. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "assert_close.h"
#include "uniform.h"

int shim_isas(void);
void shim_poisson(int isa, const double *mean, size_t count, uint64_t first_pixel, uint64_t seed, uint64_t frame,
                  uint32_t stream, double *counts);
void shim_gaussian(int isa, size_t count, uint64_t first_pixel, uint64_t seed, uint64_t frame, uint32_t stream,
                   double *normals);
void shim_words(uint64_t pixel, uint64_t seed, uint64_t frame, uint32_t stream, uint32_t draw, uint64_t words[2]);
void shim_random123(const uint32_t counter[4], const uint32_t key[2], uint32_t words[4]);
void shim_bits(uint64_t seed, uint32_t stream, size_t count, uint64_t *bits);
void shim_uniforms(uint64_t seed, uint32_t stream, size_t count, double *uniforms);
void shim_normals(uint64_t seed, uint32_t stream, size_t count, double *normals);
double shim_unit(uint64_t word);
double shim_log(double x);
double shim_exp(double x);
double shim_cos(double turns);
double shim_log_probability(double count, double mean);
void shim_propose(double u, double mean, double proposal[3]);

static double *numbers(size_t count) {
    double *memory = malloc(count * sizeof *memory);
    assert_non_null(memory);
    return memory;
}

/* Means of every magnitude from 1e-3 to 1e12, some of them 0. */
static double *mixed_means(size_t count) {
    double *mean = numbers(count);
    uint64_t seed = 21;
    for (size_t i = 0; i < count; i++)
        mean[i] = i % 37 == 0 ? 0 : pow(10, 15 * uniform(&seed) - 3);
    return mean;
}

/* ---- Generator and elementary functions */

TEST(words_match_philox) {
    uint64_t seed = 4;
    for (size_t i = 0; i < 1000; i++) {
        uint32_t part[6], expected[4];
        for (size_t j = 0; j < 6; j++)
            part[j] = i == 0 ? 0 : (uint32_t)(uniform(&seed) * 0x1p32);
        const uint32_t stream = part[1] >> 16, draw = part[1] & 0xffff;
        uint64_t words[2];
        shim_words(part[0], part[4] | (uint64_t)part[5] << 32, part[2] | (uint64_t)part[3] << 32, stream, draw, words);
        shim_random123(part, part + 4, expected);
        assert_true(words[0] == (expected[0] | (uint64_t)expected[1] << 32));
        assert_true(words[1] == (expected[2] | (uint64_t)expected[3] << 32));
    }
}

TEST(unit_numbers_are_centres_of_cells) {
    assert_true(shim_unit(0) == 0x1p-53);
    assert_true(shim_unit(UINT64_MAX) == 1 - 0x1p-53);
    assert_true(shim_unit(UINT64_C(1) << 63) == 0.5 + 0x1p-53);
    assert_true(shim_unit(0xfff) == 0x1p-53);
}

TEST(functions_agree_with_extended_precision) {
    uint64_t seed = 8;
    assert_true(shim_exp(0) == 1 && shim_log(1) == 0);
    for (size_t i = 0; i < 200000; i++) {
        const double number = uniform(&seed), wide = pow(10, 300 * uniform(&seed) - 200);
        const double near_1 = 1 + 0x1p-20 * (number - 0.5), small = -10 * number;
        assert_close(shim_log(wide), (double)logl(wide), 4e-16, 0);
        assert_close(shim_log(near_1), (double)logl(near_1), 4e-16, 0);
        assert_close(shim_exp(small), (double)expl(small), 4e-16, 0);
        assert_close(shim_exp(70 * small), (double)expl(70 * small), 4e-16, 0);
        assert_close(shim_cos(number), (double)cosl(2 * M_PIl * number), 5e-16, 0x1p-60);
    }
}

/* log(1 + x) - x; by its series near 0, where the difference would cancel. */
static long double log_excess(long double x) {
    if (fabsl(x) > 1e-3L)
        return log1pl(x) - x;
    long double sum = 0;
    for (int n = 8; n >= 2; n--)
        sum = sum * x + (n % 2 == 0 ? -1.0L : 1.0L) / n;
    return sum * x * x;
}

/* log of the Poisson probability; factorials are exact up to 25, and the series is accurate to 1e-16 above. */
static long double exact_log_probability(double count, double mean) {
    const long double k = count, relative = (mean - k) / k;
    if (count <= 25) {
        long double factorial = 1;
        for (int i = 2; i <= (int)count; i++)
            factorial *= i;
        return k * logl(mean) - mean - logl(factorial);
    }
    const long double rest = 1 / (12 * k) - 1 / (360 * k * k * k) + 1 / (1260 * powl(k, 5)) - 1 / (1680 * powl(k, 7));
    return k * log_excess(relative) - 0.5L * logl(2 * M_PIl * k) - rest;
}

TEST(log_probability_keeps_its_digits) {
    uint64_t seed = 6;
    for (double count = 1; count <= 60; count++)
        for (double mean = 10; mean < 60; mean += 1.7)
            assert_close(shim_log_probability(count, mean), (double)exact_log_probability(count, mean), 2e-15, 4e-15);
    for (size_t i = 0; i < 100000; i++) {
        const double mean = pow(10, 3 + 9 * uniform(&seed));
        const double count = floor(mean + sqrt(mean) * (20 * uniform(&seed) - 10));
        assert_close(shim_log_probability(count, mean), (double)exact_log_probability(count, mean), 2e-15, 4e-15);
    }
}

/* ---- Exactness of the rejection */

/* The acceptance probability must be at most 1, and the squeeze must lie below it, for every u and mean. */
TEST(hat_dominates_and_squeeze_stays_below) {
    const double means[] = {10,   10.25, 10.5, 11,    12.3, 13.7, 15,  17.9, 20.7, 25,   30,  40.4,
                            50.2, 70,    100,  300.5, 1000, 1e4,  1e5, 1e6,  1e8,  1e10, 1e12};
    const int steps = in_long() ? 60000 : 15000;
    for (size_t m = 0; m < sizeof means / sizeof *means; m++) {
        const double mean = means[m];
        for (int i = 1; i < steps; i++) {
            /* uniformly through the middle, and ever closer to both ends */
            const int end = i % 8;
            const double even = (double)i / steps - 0.5, close = 0.5 - 0.02 * exp(-20.0 * i / steps);
            const double u = end == 1 ? close : end == 2 ? -close : even;
            double proposal[3];
            shim_propose(u, mean, proposal);
            const double count = proposal[0], scale = proposal[1], squeeze = proposal[2];
            const int possible = count >= 0 && scale > 0;
            const double chance = possible ? (double)expl(exact_log_probability(count, mean)) * scale : 0;
            if (!(chance <= 1))
                fail_msg("mean %g, u %.17g: the hat is too low, chance %.9g", mean, u, chance);
            if (!(squeeze <= chance))
                fail_msg("mean %g, u %.17g: squeeze %.9g above the chance %.9g", mean, u, squeeze, chance);
        }
    }
}

/* The density of the proposals must be as given by `scale`: 1 / (d count / d u), up to the height of the hat. */
TEST(scale_is_the_slope_of_the_transformation) {
    const double mean = 1e12, height = 1.042 + (1.14 + 1.6e-6) * 1e-6;
    for (double u = -0.49; u < 0.4901; u += 0.01) {
        const double h = 1e-3 * (0.5 - fabs(u));
        double middle[3], left[3], right[3];
        shim_propose(u, mean, middle);
        shim_propose(u - h, mean, left);
        shim_propose(u + h, mean, right);
        assert_close(middle[1] * height, (right[0] - left[0]) / (2 * h), 2e-3, 0);
    }
}

/* ---- Distribution */

enum { PIXELS = 1 << 16, FRAMES = 8 };

/* Groups consecutive counts into cells with at least `least` of the expected `total`; returns the deviation of their
 * chi-square in standard deviations. */
static double chi_square_deviation(const double *counts, size_t total, double mean, double least) {
    const double spread = 12 * sqrt(mean) + 40, lowest = floor(fmax(0, mean - spread));
    const size_t bins = (size_t)(mean + spread - lowest);
    double *seen = calloc(bins, sizeof *seen);
    assert_non_null(seen);
    for (size_t i = 0; i < total; i++) {
        assert_true(counts[i] >= lowest && counts[i] < lowest + (double)bins);
        seen[(size_t)(counts[i] - lowest)]++;
    }
    double chi = 0, cells = 0, expected = 0, found = 0, left = (double)total;
    for (size_t k = 0; k < bins; k++) {
        expected += (double)total * (double)expl(exact_log_probability(lowest + (double)k, mean));
        found += seen[k];
        const int last = k + 1 == bins;
        if (!last && (expected < least || left - expected < least))
            continue;
        chi += (found - expected) * (found - expected) / fmax(expected, 1e-300);
        left -= expected;
        cells++;
        expected = found = 0;
    }
    /* Wilson and Hilferty: the cube root of chi-square over its degrees of freedom is nearly normal. */
    const double part = 2 / (9 * (cells - 1));
    free(seen);
    return (cbrt(chi / (cells - 1)) - (1 - part)) / sqrt(part);
}

static void assert_moments(const double *counts, size_t total, double mean) {
    double first = 0, second = 0, third = 0, odd = 0;
    for (size_t i = 0; i < total; i++) {
        const double z = (counts[i] - mean) / sqrt(mean);
        first += z;
        second += z * z;
        third += z * z * z;
        odd += fmod(counts[i], 2);
    }
    const double n = (double)total;
    assert_close(first / n, 0, 0, 4 / sqrt(n));
    assert_close(second / n, 1, 0, 4 * sqrt((2 + 1 / mean) / n));
    assert_close(third / n, 1 / sqrt(mean), 0, 4 * sqrt((15 + 25 / mean + 1 / (mean * mean)) / n));
    assert_close(odd / n, -0.5 * expm1(-2 * mean), 0, 4 * sqrt(0.25 / n));
}

TEST(counts_follow_the_distribution) {
    const double means[] = {0.01, 0.1, 3, 9.99, 10, 10.7, 30, 1e3, 1e6, 1e9};
    const size_t total = PIXELS * FRAMES;
    const int host = shim_isas() - 1;
    double *mean = numbers(PIXELS), *counts = numbers(total);
    for (size_t m = 0; m < sizeof means / sizeof *means; m++) {
        for (size_t i = 0; i < PIXELS; i++)
            mean[i] = means[m];
        for (size_t f = 0; f < FRAMES; f++)
            shim_poisson(host, mean, PIXELS, 0, 2024 + m, f, 0, counts + f * PIXELS);
        assert_moments(counts, total, means[m]);
        const double deviation = chi_square_deviation(counts, total, means[m], means[m] < 100 ? 20 : 2000);
        if (!(fabs(deviation) < 4)) /* neither too much scatter nor too little */
            fail_msg("mean %g: chi-square off by %.1f sigma", means[m], deviation);
    }
    free(mean);
    free(counts);
}

/* For means below 10 a count is the inverse of the distribution function at the pixel's first uniform number. */
TEST(small_means_are_inverted_exactly) {
    enum { count = 100000 };
    double *mean = numbers(count), *counts = numbers(count);
    uint64_t seed = 13;
    for (size_t i = 0; i < count; i++)
        mean[i] = i % 2 == 0 ? 10 * uniform(&seed) : pow(10, -6 * uniform(&seed));
    const uint64_t key = 3 + (UINT64_C(7) << 32), frame = 4 + (UINT64_C(9) << 32); /* every part matters */
    shim_poisson(shim_isas() - 1, mean, count, 11, key, frame, 2, counts);
    for (size_t i = 0; i < count; i++) {
        uint64_t words[2];
        shim_words(11 + i, key, frame, 2, 0, words);
        const double uniform = shim_unit(words[0]);
        long double term = expl(-mean[i]), sum = term;
        double k = 0;
        while (sum < uniform) {
            k++;
            term *= mean[i] / k;
            sum += term;
        }
        assert_true(counts[i] == k);
    }
    free(mean);
    free(counts);
}

TEST(limits_of_the_range_work) {
    enum { count = 20000 };
    double *mean = numbers(count), *counts = numbers(count);
    for (size_t i = 0; i < count; i++)
        mean[i] = i < count / 2 ? 0 : 1e12;
    for (int isa = 0; isa < shim_isas(); isa++) {
        double sum = 0;
        shim_poisson(isa, mean, count, 0, 1, 1, 0, counts);
        for (size_t i = 0; i < count / 2; i++)
            assert_true(counts[i] == 0 && !signbit(counts[i]));
        for (size_t i = count / 2; i < count; i++) {
            assert_true(counts[i] == floor(counts[i]));
            assert_close(counts[i], 1e12, 0, 6e6);
            sum += (counts[i] - 1e12) / 1e6;
        }
        assert_close(sum / (count / 2), 0, 0, 4 / sqrt(count / 2));
    }
    free(mean);
    free(counts);
}

TEST(normals_are_box_muller_transforms) {
    enum { count = 100000 };
    double *normals = numbers(count);
    shim_gaussian(shim_isas() - 1, count, 7, 5, 6, 1, normals);
    for (size_t i = 0; i < count; i++) {
        uint64_t words[2];
        shim_words(7 + i, 5, 6, 1, 0, words);
        const long double radius = sqrtl(-2 * logl(shim_unit(words[0])));
        assert_close(normals[i], (double)(radius * cosl(2 * M_PIl * shim_unit(words[1]))), 1e-15, 1e-17);
    }
    free(normals);
}

/* ---- Bits */

TEST(every_instruction_set_gives_the_same_bits) {
    enum { count = 200003 };
    double *mean = mixed_means(count), *expected = numbers(count), *counts = numbers(count);
    for (int isa = 1; isa < shim_isas(); isa++)
        for (uint64_t frame = 0; frame < 3; frame++) {
            shim_poisson(0, mean, count, 100, 12, frame, 0, expected);
            shim_poisson(isa, mean, count, 100, 12, frame, 0, counts);
            assert_memory_equal(counts, expected, count * sizeof *counts);
            shim_gaussian(0, count, 100, 12, frame, 1, expected);
            shim_gaussian(isa, count, 100, 12, frame, 1, counts);
            assert_memory_equal(counts, expected, count * sizeof *counts);
        }
    free(mean);
    free(expected);
    free(counts);
}

TEST(pieces_equal_the_whole) {
    enum { count = 10000 };
    double *mean = mixed_means(count), *whole = numbers(2 * count), *pieces = numbers(2 * count);
    const size_t lengths[] = {1, 2, 7, 8, 1023, 1024, 1025, 64, 3000, 5};
    for (int isa = 0; isa < shim_isas(); isa++) {
        shim_poisson(isa, mean, count, 50, 9, 8, 0, whole);
        shim_gaussian(isa, count, 50, 9, 8, 1, whole + count);
        for (size_t begin = 0, piece = 0; begin < count; piece++) {
            const size_t length = lengths[piece % 10], size = begin + length < count ? length : count - begin;
            shim_poisson(isa, mean + begin, size, 50 + begin, 9, 8, 0, pieces + begin);
            shim_gaussian(isa, size, 50 + begin, 9, 8, 1, pieces + count + begin);
            begin += size;
        }
        assert_memory_equal(pieces, whole, 2 * count * sizeof *whole);
    }
    free(mean);
    free(whole);
    free(pieces);
}

/* ---- Scalar random numbers */

/* Test vectors published with the generator (Random123, kat_vectors, philox4x32 10). */
TEST(philox_gives_the_published_words) {
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

TEST(sequence_counts_blocks_of_its_stream) {
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

TEST(uniforms_stay_inside_and_are_even) {
    enum { count = 1000000 };
    double *uniforms = numbers(count);
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

TEST(normals_have_the_moments_and_tails) {
    enum { count = 1000000 };
    double *normals = numbers(count);
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

TEST(sequences_differ_by_seed_and_stream) {
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

RUN_TESTS(NULL, NULL)
