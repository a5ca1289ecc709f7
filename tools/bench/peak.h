/* Peak rate of multiply-adds of one core: the hardware lower bound of products. Vectors stay in the registers. The rate
 * is that of the fastest of many samples of a millisecond, so that other work on the machine does not lower it; the
 * benchmarks sample it before and after the measured work, and use the higher one. */
#ifndef TOLIMAN_TESTS_PEAK_H
#define TOLIMAN_TESTS_PEAK_H

#include <math.h>

#include "timing.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

enum { PEAK_CHAINS = 12, PEAK_TURNS = 200000, PEAK_SAMPLES = 25 };

/* Defines a function that runs PEAK_CHAINS independent chains of multiply-adds. */
#define PEAK_LOOP(name, attributes, Vector, set, multiply_add)                                                         \
    attributes static inline void name(void) {                                                                         \
        Vector sum[PEAK_CHAINS];                                                                                       \
        const Vector a = set(0.999f), b = set(0.001f);                                                                 \
        for (int c = 0; c < PEAK_CHAINS; c++)                                                                          \
            sum[c] = b;                                                                                                \
        for (int i = 0; i < PEAK_TURNS; i++)                                                                           \
            for (int c = 0; c < PEAK_CHAINS; c++)                                                                      \
                sum[c] = multiply_add(sum[c], a, b);                                                                   \
        for (int c = 0; c < PEAK_CHAINS; c++)                                                                          \
            __asm__ volatile("" : : "m"(sum[c])); /* the result is used */                                             \
    }

typedef float peak_floats __attribute__((vector_size(16)));
typedef double peak_doubles __attribute__((vector_size(16)));
#define PEAK_FLOATS(value) ((peak_floats){0} + (value))
#define PEAK_DOUBLES(value) ((peak_doubles){0} + (double)(value))
#define PEAK_PLAIN(s, a, b) ((s) * (a) + (b))
PEAK_LOOP(peak_float_baseline, , peak_floats, PEAK_FLOATS, PEAK_PLAIN)
PEAK_LOOP(peak_double_baseline, , peak_doubles, PEAK_DOUBLES, PEAK_PLAIN)
#if defined(__x86_64__)
#define PEAK_AVX2 __attribute__((target("avx2,fma")))
#define PEAK_AVX512 __attribute__((target("avx512f")))
PEAK_LOOP(peak_float_avx2, PEAK_AVX2, __m256, _mm256_set1_ps, _mm256_fmadd_ps)
PEAK_LOOP(peak_float_avx512, PEAK_AVX512, __m512, _mm512_set1_ps, _mm512_fmadd_ps)
PEAK_LOOP(peak_double_avx2, PEAK_AVX2, __m256d, _mm256_set1_pd, _mm256_fmadd_pd)
PEAK_LOOP(peak_double_avx512, PEAK_AVX512, __m512d, _mm512_set1_pd, _mm512_fmadd_pd)
#endif

typedef enum peak_isa { PEAK_IS_BASELINE, PEAK_IS_AVX2, PEAK_IS_AVX512 } peak_isa;

/* The widest instruction set of this processor. */
static inline peak_isa peak_widest(void) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f"))
        return PEAK_IS_AVX512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        return PEAK_IS_AVX2;
#endif
    return PEAK_IS_BASELINE;
}

static inline double peak_of(void (*loop)(void), int lanes) {
    double fastest = HUGE_VAL;
    for (int i = 0; i < PEAK_SAMPLES; i++) {
        const double start = processor_s();
        loop();
        fastest = fmin(fastest, processor_s() - start);
    }
    return 2.0 * lanes * (double)PEAK_CHAINS * (double)PEAK_TURNS / fastest * 1e-9;
}

/* GFLOP/s of float32, and of float64. */
static inline double peak_float(peak_isa isa) {
#if defined(__x86_64__)
    if (isa == PEAK_IS_AVX512)
        return peak_of(peak_float_avx512, 16);
    if (isa == PEAK_IS_AVX2)
        return peak_of(peak_float_avx2, 8);
#endif
    (void)isa;
    return peak_of(peak_float_baseline, 4);
}

static inline double peak_double(peak_isa isa) {
#if defined(__x86_64__)
    if (isa == PEAK_IS_AVX512)
        return peak_of(peak_double_avx512, 8);
    if (isa == PEAK_IS_AVX2)
        return peak_of(peak_double_avx2, 4);
#endif
    (void)isa;
    return peak_of(peak_double_baseline, 2);
}

#endif
