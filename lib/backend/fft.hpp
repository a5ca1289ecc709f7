// FFTW3: transforms with estimated plans, whose results are reproducible.
#pragma once
#include <complex>
#include <cstddef>
#include <memory>

namespace toliman::fft {

// Version of the library in use.
const char *version() noexcept;

// The smallest even number from n on without prime factors above 5.
size_t fast_size(size_t n) noexcept;

// Forward transform of n x n complex numbers in place, with its memory. Equal input gives equal bits. One thread at a
// time per object.
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

// Forward transform of n real numbers (n even) in place: x[0 ... n-1] becomes n/2 + 1 complex numbers, interleaved. x
// has n + 2 elements, aligned to 64 bytes. Several threads may use one object.
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
