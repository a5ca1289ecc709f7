// Method: exact Poisson variates of any mean from 0 to 1e12.
//     mean < 10   inversion: the count is the number of values of the distribution function below a uniform number
//     mean >= 10  transformed rejection: a uniform number u proposes a count k(u); a second one, v, accepts it if
//                 v <= squeeze, or else if v/scale <= probability(k)
// There is no normal approximation, however large the mean. The transformation follows the skewness of the distribution
// more closely than that of Hormann's PTRS, of which 23 % of the proposals need the second test, against 8.4 % here
// (prototype), and whose hat is exceeded by up to 0.5 % at small means. The hat used here was verified to dominate.
//
// Random numbers are counter-based (Philox-4x32-10): a pixel's numbers are a function of (seed, stream, frame, pixel,
// draw). Frames can therefore be generated in any order and on any number of threads with the same counts, and rejected
// proposals of one pixel do not shift the numbers of another. A sequential generator has neither property.
//
// Every stage is a plain loop over 64-bit arrays of a block of 1024 pixels, so that it vectorises; rejected proposals
// are compacted for the next draw. Measured time: tools/docs/benchmarks.md.
//
// Reference: Hormann (1993), "The transformed rejection method for generating Poisson random variables", Insurance:
// Mathematics and Economics 12, 39; Salmon, Moraes, Dror and Shaw (2011), "Parallel random numbers: as easy as 1, 2,
// 3", SC '11.
#include "kernels/poisson.hpp"

#include <cmath>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "kernels/cis.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr size_t kBlock = 1024;
constexpr double kInversionLimit = 10; // smaller means use inversion
constexpr uint32_t kMaxDraws = 1024;   // a proposal is rejected with probability below 1/3: never reached

// ---- Uniform random numbers

#if defined(__AVX512F__)
constexpr size_t kLanes = 8;
#elif defined(__AVX2__)
constexpr size_t kLanes = 4;
#else
constexpr size_t kLanes = 2;
#endif
typedef uint64_t Words __attribute__((vector_size(kLanes * sizeof(uint64_t))));

// Products of the low halves of the lanes; the high halves are ignored.
inline Words multiply_low(Words a, Words b) {
#if defined(__AVX512F__)
    // The unmasked form causes a warning in gcc 12's own header.
    return (Words)_mm512_maskz_mul_epu32(0xff, (__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
    return (Words)_mm256_mul_epu32((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
    return (Words)_mm_mul_epu32((__m128i)a, (__m128i)b);
#else
    return (a & 0xffffffffu) * (b & 0xffffffffu);
#endif
}

// Given     place [count], pixels relative to first_pixel; key; draw, the number of the attempt
// Returned  a, b [count], 64 random bits each
// Notes     all three arrays have space for whole vectors
// Reference Salmon et al. (2011), Philox-4x32-10 of counter (pixel, draw + 2^16 stream, frame low, frame high)
void draw_words(const uint64_t *place, size_t count, uint64_t first_pixel, NoiseKey key, uint32_t draw, uint64_t *a,
                uint64_t *b) {
    for (size_t i = 0; i < count; i += kLanes) {
        Words c0;
        __builtin_memcpy(&c0, place + i, sizeof c0);
        c0 += first_pixel;
        Words c1 = Words{} + (draw | static_cast<uint64_t>(key.stream) << 16);
        Words c2 = Words{} + (key.frame & 0xffffffffu), c3 = Words{} + (key.frame >> 32);
        uint32_t k0 = static_cast<uint32_t>(key.seed), k1 = static_cast<uint32_t>(key.seed >> 32);
        for (int round = 0; round < 10; round++) {
            const Words product0 = multiply_low(Words{} + 0xD2511F53u, c0);
            const Words product1 = multiply_low(Words{} + 0xCD9E8D57u, c2);
            c0 = (product1 >> 32) ^ c1 ^ k0;
            c1 = product1;
            c2 = (product0 >> 32) ^ c3 ^ k1;
            c3 = product0;
            k0 += 0x9E3779B9u;
            k1 += 0xBB67AE85u;
        }
        const Words word_a = (c0 & 0xffffffffu) | c1 << 32, word_b = (c2 & 0xffffffffu) | c3 << 32;
        __builtin_memcpy(a + i, &word_a, sizeof word_a);
        __builtin_memcpy(b + i, &word_b, sizeof word_b);
    }
}

// Uniform number: the centre of one of 2^52 equal cells of (0, 1), never 0 or 1.
inline double unit(uint64_t word) {
    const uint64_t bits = word >> 12 | 0x3ff0000000000000u;
    double value;
    __builtin_memcpy(&value, &bits, sizeof value);
    return value - (1.0 - 0x1p-53);
}

// ---- Elementary functions. libm is not used: its bits depend on its version and on the CPU.

inline double from_bits(uint64_t bits) {
    double value;
    __builtin_memcpy(&value, &bits, sizeof value);
    return value;
}

inline uint64_t to_bits(double value) {
    uint64_t bits;
    __builtin_memcpy(&bits, &value, sizeof bits);
    return bits;
}

// Given     x > 0, not subnormal; less
// Returned  log(x) - less, without cancellation for less near x - 1
// Reference fdlibm e_log.c; x = 2^e (1 + f) with 1 + f between sqrt(1/2) and sqrt(2)
inline double log_minus(double x, double less) {
    const uint64_t bits = to_bits(x);
    const uint64_t exponent = (bits - 0x3fe6a09e667f3bcdu + (uint64_t{1024} << 52)) >> 52; // e + 1024
    const double e = from_bits(exponent | 0x4330000000000000u) - (0x1p52 + 1024.0);
    const double f = from_bits(bits - ((exponent - 1024) << 52)) - 1.0;
    const double s = f / (2.0 + f), z = s * s, half_square = 0.5 * f * f;
    const double series = z * (6.666666666666735130e-01 +
                               z * (3.999999999940941908e-01 +
                                    z * (2.857142874366239149e-01 +
                                         z * (2.222219843214978396e-01 +
                                              z * (1.818357216161805012e-01 +
                                                   z * (1.531383769920937332e-01 + z * 1.479819860511658591e-01))))));
    const double correction = half_square - (s * (half_square + series) + e * 1.90821492927058770002e-10);
    return e * 6.93147180369123816490e-01 - (correction - (f - less));
}

// Given     x in [-700, 0]
// Returned  exp(x), exactly 1 for 0
// Reference fdlibm e_exp.c
inline double exponential(double x) {
    const double e = nearest_whole(x * 1.44269504088896338700);
    const double high = x - e * 6.93147180369123816490e-01, low = e * 1.90821492927058770002e-10;
    const double r = high - low, t = r * r;
    const double c = r - t * (1.66666666666666019037e-01 +
                              t * (-2.77777777770155933842e-03 +
                                   t * (6.61375632143793436117e-05 +
                                        t * (-1.65339022054652515390e-06 + t * 4.13813679705723846039e-08))));
    const double mantissa = 1.0 - ((low - r * c / (2.0 - c)) - high);
    return from_bits(to_bits(mantissa) + (to_bits(e + 0x1.8p52) << 52));
}

// Given     cycles in [0, 1]
// Returned  cos(2 pi cycles)
inline double cosine_of_cycles(double cycles) {
    const double quarter = nearest_whole(4.0 * cycles);
    double cosine, sine;
    cis_quarters(quarter > 2.0 ? quarter - 4.0 : quarter, cycles - 0.25 * quarter, cosine, sine);
    return cosine;
}

// ---- Transformed rejection for means from 10 up

// log k! minus Stirling's k log k - k + log(2 pi k)/2, for k = 1 ... 15, where its asymptotic series is inaccurate; [0]
// is not used.
constexpr double kStirlingCorrection[16] = {0,
                                            0.0810614667953272582,
                                            0.0413406959554092941,
                                            0.0276779256849983391,
                                            0.0207906721037650931,
                                            0.0166446911898211922,
                                            0.013876128823070748,
                                            0.0118967099458917701,
                                            0.0104112652619720965,
                                            0.00925546218271273292,
                                            0.00833056343336287126,
                                            0.00757367548795184079,
                                            0.00694284010720952987,
                                            0.00640899418800420707,
                                            0.00595137011275884774,
                                            0.00555473355196280137};

// Given     count, an integer from 1 to 2^51; mean > 0; listed, the table's entry if count < 16
// Returned  log of the Poisson probability of count, to a few 1e-15 within ten standard deviations
// Notes     count log(mean/count) - (mean - count) is formed from the relative difference of mean and count, because
//           its two terms are large and nearly cancel.
inline double log_probability(double count, double mean, double listed) {
    const double inverse = 1.0 / count, square = inverse * inverse;
    const double series =
        inverse * (8.33333333333333333e-02 -
                   square * (2.77777777777777778e-03 -
                             square * (7.93650793650793651e-04 -
                                       square * (5.95238095238095238e-04 - square * 8.41750841750841751e-04))));
    const double correction = count < 16.0 ? listed : series;
    const double relative = (mean - count) * inverse, ratio = 1.0 + relative;
    const double rounding = relative - (ratio - 1.0);
    const double excess = log_minus(ratio, relative) + rounding / ratio;
    return count * excess - 0.5 * log_minus(count, 0.0) - 0.91893853320467274178 - correction;
}

// A proposed count.
struct Proposal {
    double count;   // negative: to be rejected
    double scale;   // probability(count) * scale is the probability of acceptance; <= 0: to be rejected
    double squeeze; // lower bound of the probability of acceptance
};

// Given     u in (-1/2, 1/2), mean >= 10
// Returned  the proposal: floor of the transformed u
// Notes     x(u) approximates the normal quantile; mean + s x + x^2/6 adds the skewness. The scale of the hat and the
//           squeeze were fitted by scanning all u; tests/kernel/test_poisson.c repeats the scan.
// Reference Hormann (1993), with a closer transformation
inline Proposal propose(double u, double mean) {
    constexpr double a = 0.027166494864850132, b0 = 2.5527761943248795, b1 = 0.6255570417112055,
                     b2 = 16.465630013737552;
    const double s = std::sqrt(mean), inverse_s = 1.0 / s;
    const double edge = 0.5 - std::fabs(u), inverse_edge = 1.0 / edge, pole = a * inverse_edge, w = u * u;
    const double x = u * (pole + (b0 + w * (b1 + w * b2)));
    const double slope = 0.5 * pole * inverse_edge + (b0 + w * (3.0 * b1 + w * (5.0 * b2)));
    const double y = mean + (0.5 - 1.0 / 6.0) + x * (s + x * (1.0 / 6.0));
    const double nearest = nearest_whole(y);
    return {nearest > y ? nearest - 1.0 : nearest,
            slope * (s + x * (1.0 / 3.0)) / (1.042 + inverse_s * (1.14 + 1.6 * inverse_s)),
            edge >= 0.02 ? 0.9615 - 2.1 * inverse_s : 0.0};
}

// Pending pixels of a block, compacted.
struct Work {
    alignas(64) uint64_t place[kBlock] = {}; // index in the block; vectors may read beyond the last one
    alignas(64) uint64_t a[kBlock], b[kBlock];
    alignas(64) double mean[kBlock], count[kBlock], scale[kBlock], uniform[kBlock];
    alignas(64) uint64_t open[kBlock]; // 1: not accepted yet
    alignas(64) uint64_t kept[kBlock];
    alignas(64) double listed[kBlock];
};

// Compacts the open pixels among the first `size`; returns their number.
size_t keep_open(Work &work, size_t size) {
    constexpr size_t kGroup = 64; // pixels whose flags are gathered in one word
    size_t kept = 0;
    for (size_t i = size; i % kGroup != 0; i++)
        work.open[i] = 0;
    for (size_t first = 0; first < size; first += kGroup) {
        uint64_t flags = 0;
        for (size_t j = 0; j < kGroup; j++)
            flags |= work.open[first + j] << j;
        for (; flags != 0; flags &= flags - 1)
            work.kept[kept++] = first + static_cast<size_t>(__builtin_ctzll(flags));
    }
    for (size_t i = 0; i < kept; i++) {
        const size_t from = work.kept[i];
        work.place[i] = work.place[from];
        work.mean[i] = work.mean[from];
        work.count[i] = work.count[from];
        work.scale[i] = work.scale[from];
        work.uniform[i] = work.uniform[from];
    }
    return kept;
}

// Proposes a count for each pixel; accepts those below the squeeze.
void propose_all(Work &work, size_t size) {
    for (size_t i = 0; i < size; i++) {
        const Proposal proposal = propose(unit(work.a[i]) - 0.5, work.mean[i]);
        const double uniform = unit(work.b[i]);
        work.count[i] = proposal.count;
        work.scale[i] = proposal.scale;
        work.uniform[i] = uniform;
        work.open[i] = uniform <= proposal.squeeze ? 0 : 1;
    }
}

// The exact acceptance test, for the pixels that the squeeze left open.
void test_all(Work &work, size_t size) {
    for (size_t i = 0; i < size; i++) // a look-up in the loop below would prevent its vectorisation
        work.listed[i] = kStirlingCorrection[to_bits(work.count[i] + 0x1.8p52) & 15];
    for (size_t i = 0; i < size; i++) {
        const double count = work.count[i], scale = work.scale[i];
        const double positive = count > 1.0 ? count : 1.0, bounded = positive < 0x1p51 ? positive : 0x1p51;
        const double of_many = log_probability(bounded, work.mean[i], work.listed[i]);
        const double chance = count == 0.0 ? -work.mean[i] : of_many;
        const double safe_scale = scale > 0x1p-900 ? scale : 0x1p-900;
        const bool accepted = log_minus(work.uniform[i] / safe_scale, 0.0) <= chance;
        work.open[i] = ((count >= 0.0) & (scale > 0.0) & accepted) ? 0 : 1;
    }
}

// is_whole: place[i] = i, as long as no pixel has been accepted.
void count_by_rejection(Work &work, size_t size, bool is_whole, uint64_t first_pixel, NoiseKey key, double *counts) {
    for (uint32_t draw = 0; size > 0 && draw < kMaxDraws; draw++) {
        draw_words(work.place, size, first_pixel, key, draw, work.a, work.b);
        propose_all(work, size);
        // A count is overwritten by the next proposal if this one is rejected.
        if (is_whole) // a copy is quicker than the scatter below
            for (size_t i = 0; i < size; i++)
                counts[i] = work.count[i];
        else
            for (size_t i = 0; i < size; i++)
                counts[work.place[i]] = work.count[i];
        is_whole = false;
        size = keep_open(work, size);
        test_all(work, size);
        size = keep_open(work, size);
    }
}

// ---- Inversion for means below 10

// Counts the values of the distribution function below the uniform number. The search stops at a term below 2^-60,
// where the sum is 1 up to rounding.
void count_by_inversion(Work &work, size_t size, uint64_t first_pixel, NoiseKey key, double *counts) {
    double *term = work.scale, *sum = work.uniform;
    draw_words(work.place, size, first_pixel, key, 0, work.a, work.b);
    for (size_t i = 0; i < size; i++) {
        work.count[i] = 0;
        term[i] = sum[i] = exponential(-work.mean[i]);
    }
    for (uint64_t k = 1, open = size; open > 0; k++) {
        const double inverse = 1.0 / static_cast<double>(k);
        open = 0;
        for (size_t i = 0; i < size; i++) {
            const bool above = (unit(work.a[i]) > sum[i]) & (term[i] > 0x1p-60);
            work.count[i] += above ? 1.0 : 0.0;
            open += above ? 1 : 0;
            term[i] *= work.mean[i] * inverse;
            sum[i] += term[i];
        }
    }
    for (size_t i = 0; i < size; i++)
        counts[work.place[i]] = work.count[i];
}

// ---- Blocks

// Selects the pixels of a block on one side of the limit; returns their number.
size_t select(const double *mean, size_t size, bool above_limit, Work &work) {
    size_t selected = 0;
    for (size_t i = 0; i < size; i++) {
        work.place[selected] = i;
        work.mean[selected] = mean[i];
        selected += (mean[i] >= kInversionLimit) == above_limit ? 1 : 0;
    }
    return selected;
}

// Selects the whole block unless a mean is below the limit.
bool select_whole(const double *mean, size_t size, Work &work) {
    uint64_t small = 0;
    for (size_t i = 0; i < size; i++) {
        work.place[i] = i;
        work.mean[i] = mean[i];
        small |= mean[i] >= kInversionLimit ? 0 : 1;
    }
    return small == 0;
}

void poisson(const double *mean, size_t count, uint64_t first_pixel, NoiseKey key, double *counts) noexcept {
    Work work;
    for (size_t begin = 0; begin < count; begin += kBlock) {
        const size_t size = count - begin < kBlock ? count - begin : kBlock;
        const bool is_whole = select_whole(mean + begin, size, work);
        const size_t large = is_whole ? size : select(mean + begin, size, true, work);
        count_by_rejection(work, large, is_whole, first_pixel + begin, key, counts + begin);
        if (large < size)
            count_by_inversion(work, select(mean + begin, size, false, work), first_pixel + begin, key, counts + begin);
    }
}

// Box and Muller (1958). Only one normal of each pair is used, so that a pixel does not depend on its neighbour.
void gaussian(size_t count, uint64_t first_pixel, NoiseKey key, double *normals) noexcept {
    alignas(64) uint64_t place[kBlock], a[kBlock], b[kBlock];
    for (size_t i = 0; i < kBlock; i++)
        place[i] = i;
    for (size_t begin = 0; begin < count; begin += kBlock) {
        const size_t size = count - begin < kBlock ? count - begin : kBlock;
        draw_words(place, size, first_pixel + begin, key, 0, a, b);
        for (size_t i = 0; i < size; i++)
            normals[begin + i] = std::sqrt(-2.0 * log_minus(unit(a[i]), 0.0)) * cosine_of_cycles(unit(b[i]));
    }
}

} // namespace
} // namespace TOLIMAN_ISA

extern const PoissonKernels TOLIMAN_ISA_TABLE(poisson) = {TOLIMAN_ISA::poisson, TOLIMAN_ISA::gaussian};

} // namespace toliman::kernels
