// Non-uniform FFT of type 1: sums over samples at arbitrary times at the frequencies (k - modes/2) df + f.
#pragma once
#include "backend/fft.hpp"
#include "base/buffer.hpp"
#include "kernels/spread.hpp"

namespace toliman::period {

// Spreads samples onto an oversampled grid with a Kaiser-Bessel kernel, transforms it and divides by the transform of
// the kernel: see nufft.cpp.
class Nufft {
  public:
    // Kernel and grid. Each sum has an error of at most `error` times the sum of |weights|, rounding included.
    struct Choice {
        size_t modes, cells, width, lanes;
        double error;
    };
    // Returns the cheapest choice with at most this error, or the most accurate one.
    static Choice choose(size_t modes, double error) noexcept;

    explicit Nufft(const Choice &choice);

    double error() const noexcept { return choice_.error; }
    // Length of a grid in doubles; transform() replaces it by cells/2 + 1 complex numbers.
    size_t grid_size() const noexcept { return choice_.cells + kernels::kSpreadLanes; }
    // Spreads weights[p] times cosine and sine of 2 pi f t onto grids[2 p] and grids[2 p + 1], which must be 0 before.
    void spread(const kernels::SpreadSamples &samples, double df, double f_high, double f_low, size_t pairs,
                double *const *grids) const noexcept;
    void transform(double *grid) const noexcept;
    // Returns sum of weight exp(2 pi i ((k - modes/2) df + f) t), from a transformed pair of grids.
    std::complex<double> sum(const double *cosines, const double *sines, size_t k) const noexcept;

  private:
    void make_coefficients(long double beta);
    void make_corrections(long double beta);

    Choice choice_;
    kernels::SpreadShape shape_;
    Buffer<double> coefficients_, corrections_; // 1/(transform of the kernel) at modes 0 ... modes/2
    fft::Real fft_;
};

} // namespace toliman::period
