// The matrix Fourier transform from pupil to detector: exact pixel positions, only the pixels asked for.
#pragma once
#include "base/buffer.hpp"
#include "kernels/field.hpp"

namespace toliman::optics {

// A complex plane's memory.
class Plane {
  public:
    explicit Plane(size_t count) : re_(count), im_(count) {}
    kernels::Field field() noexcept { return {re_.data(), im_.data()}; }

  private:
    Buffer<double> re_, im_;
};

class MatrixDft {
  public:
    MatrixDft(size_t samples, size_t rows, size_t cols);

    // step: phase in cycles of one pupil sample times one pixel, (D/N) p / lambda.
    void set_step(long double step) noexcept;

    // focal [rows][cols] = sum over pupil [samples][samples] of E exp(-2 pi i (x u + y v) step).
    void transform(kernels::Field pupil, kernels::Field focal) noexcept;

  private:
    size_t samples_, rows_, cols_;
    Buffer<double> cosine_x_, sine_x_, cosine_y_, sine_y_;
    Buffer<double> even_, odd_;               // folded pupil
    Buffer<double> even_middle_, odd_middle_; // transformed along x
    Buffer<double> ee_, eo_, oe_, oo_;        // transformed along y
};

} // namespace toliman::optics
