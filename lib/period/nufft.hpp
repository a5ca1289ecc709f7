// Non-uniform Fourier transform of type 1: sums over samples at any times, at frequencies (k - modes/2) df + f.
#pragma once
#include "backend/fft.hpp"
#include "base/buffer.hpp"
#include "kernels/spread.hpp"

namespace toliman::period {

// Kaiser-Bessel kernel, evaluated as polynomials, on a grid of more cells than modes (Barnett, Magland
// and af Klinteberg 2019, SIAM J. Sci. Comput. 41, C479, on kernels of this kind; Fessler and Sutton 2003 on this one).
class Nufft {
  public:
    // Kernel and grid: sums are then within `error` of the sum of |weights|, rounding included.
    struct Choice {
        size_t modes, cells, width, lanes;
        double error;
    };
    // The cheapest with this error, or the least error there is.
    static Choice choose(size_t modes, double error) noexcept;

    explicit Nufft(const Choice &choice);

    double error() const noexcept { return choice_.error; }
    // Length of a grid; each becomes cells/2 + 1 complex numbers in place.
    size_t grid_size() const noexcept { return choice_.cells + kernels::kSpreadLanes; }
    // grids[2 p], grids[2 p + 1], all 0 before: cosine and sine parts of weights[p]
    void spread(const kernels::SpreadSamples &samples, double df, double f_high, double f_low, size_t pairs,
                double *const *grids) const noexcept;
    void transform(double *grid) const noexcept;
    // sum of weight exp(2 pi i ((k - modes/2) df + f) t), from the transformed pair of grids.
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
