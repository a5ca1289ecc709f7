// Interpolation of a sampled, band-limited image at shifted pixels, with derivatives by the shift: a separable window
// of a few samples. The samples must be those of the image divided, in the frequency domain, by the window's transform.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kMostTaps = 32;
constexpr size_t kShiftOrders = 3; // the value and two derivatives

struct ShiftKernels {
    // Given     samples; tap t of a sum is at samples[offset[t]]; weights [orders][kMostTaps]; taps <= kMostTaps;
    //           orders 1 to 3
    // Returned  out[o][i], i < count: sum over t of weights[o][t] samples[offset[t] + i]
    // Notes     the same bits on every instruction set
    void (*sum)(const double *samples, const size_t *offset, const double *weights, size_t orders, size_t taps,
                size_t count, double *const *out) noexcept;

    // The adjoint of sum() for values.
    // Given     values [count]; offset, weights [taps], taps as of sum()
    // Returned  samples[offset[t] + i], i < count: plus weights[t] values[i], tap after tap
    // Notes     the same bits on every instruction set
    void (*spread)(const double *values, const size_t *offset, const double *weights, size_t taps, size_t count,
                   double *samples) noexcept;
};
TOLIMAN_ISA_DECLARE(ShiftKernels, shift)

// The Kaiser-Bessel window of `taps` samples, I_0(beta sqrt(1 - x^2)) for |x| = |distance|/(taps/2) <= 1, and its
// transform.
struct Window {
    size_t taps = 0;
    double beta = 0, peak = 1; // peak: I_0(beta)

    // The window of this many taps for images without frequencies above `cutoff` cycles per sample.
    static Window make(size_t taps, double cutoff) noexcept;
    // With this beta.
    static Window of(size_t taps, double beta) noexcept;

    // Given     0 <= fraction < 1
    // Returned  weights [orders][kMostTaps] of the samples at -taps/2 + 1 ... taps/2 for the value at `fraction`, and
    //           its derivatives by the fraction
    // Notes     error 1e-14 of the weight or 1e-16 of the largest one; the same bits everywhere
    void weights(double fraction, size_t orders, double *weights) const noexcept;

    // The transform at a frequency in cycles per sample: sum over the taps of weight times cos(2 pi f distance), for an
    // infinitely fine grid of samples.
    double transform(double frequency) const noexcept;

    // Largest sum over the aliases of a frequency up to `cutoff` of their part of the interpolated image.
    double error(double cutoff) const noexcept;
};

} // namespace toliman::kernels
