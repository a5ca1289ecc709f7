// FFTW3.
#pragma once
#include <complex>
#include <cstddef>
#include <memory>

namespace toliman::fft {

// Version text of the library in use.
const char *version() noexcept;

// A forward transform of n x n complex numbers in place, with its memory. Plans are estimated, so that equal input
// gives equal bits. One at a time per object.
class Square {
  public:
    explicit Square(size_t n);
    ~Square();
    Square(const Square &) = delete;
    Square &operator=(const Square &) = delete;
    std::complex<double> *data() noexcept;
    void transform() noexcept;

  private:
    struct Plan;
    std::unique_ptr<Plan> plan_;
};

// Forward transforms of n real numbers (n even) in place: x[0 ... n-1] becomes n/2 + 1 complex numbers, real and
// imaginary parts by turns, of memory on 64-byte boundaries. Runs on several threads at once.
class Real {
  public:
    explicit Real(size_t n);
    ~Real();
    Real(const Real &) = delete;
    Real &operator=(const Real &) = delete;
    void transform(double *x) const noexcept;

  private:
    void *plan_;
};

} // namespace toliman::fft
