// Method: direct summation with one sine and cosine per sample and frequency, for the frequencies at which the
// non-uniform FFT does not reach the tolerance. With half the phase a = pi f t,
//     u = 1 - cos 2a = 2 sin^2 a,    v = sin 2a = 2 sin a cos a
// have no cancellation at low frequencies, where 1 - cos of the full phase would lose all digits. Sums run over blocks
// of 64 samples in plain double and over the blocks with two-sum, so that the error does not grow with the number of
// samples.
#include "kernels/direct.hpp"

#include "kernels/cis.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr size_t kBlock = 64; // samples per uncompensated sum
constexpr size_t kLanes = kDirectLanes;

void add_block(const double *half_high, const double *half_low, const DirectSamples &samples, size_t begin, size_t end,
               double (*sums)[kLanes]) noexcept {
    for (size_t i = begin; i < end; i++) {
        const double t_high = samples.t_high[i], t_low = samples.t_low[i], w = samples.w[i], x = samples.x[i];
        for (size_t j = 0; j < kLanes; j++) {
            double c, s;
            cis_product(half_high[j], half_low[j], t_high, t_low, c, s);
            const double u = 2 * (s * s), v = 2 * (s * c), wu = w * u, wv = w * v;
            sums[kU][j] += wu;
            sums[kV][j] += wv;
            sums[kUU][j] += wu * u;
            sums[kUV][j] += wu * v;
            sums[kVV][j] += wv * v;
            sums[kXU][j] += x * u;
            sums[kXV][j] += x * v;
        }
    }
}

void direct(const double *half_high, const double *half_low, const DirectSamples &samples, double *high,
            double *low) noexcept {
    for (size_t begin = 0; begin < samples.n; begin += kBlock) {
        alignas(64) double sums[kDirectSums][kLanes] = {};
        add_block(half_high, half_low, samples, begin, samples.n - begin < kBlock ? samples.n : begin + kBlock, sums);
        for (size_t i = 0; i < kDirectSums * kLanes; i++) {
            const double a = high[i], b = sums[i / kLanes][i % kLanes], sum = a + b, back = sum - a;
            low[i] += (a - (sum - back)) + (b - back);
            high[i] = sum;
        }
    }
}

} // namespace
} // namespace TOLIMAN_ISA

extern const DirectKernels TOLIMAN_ISA_TABLE(direct) = {TOLIMAN_ISA::direct};

} // namespace toliman::kernels
