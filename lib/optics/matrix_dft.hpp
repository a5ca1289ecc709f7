// The matrix Fourier transform from pupil to detector: exact pixel positions, only the pixels asked for.
#pragma once
#include <vector>

#include "base/buffer.hpp"
#include "kernels/field.hpp"
#include "optics/pupil.hpp"

namespace toliman::optics {

// Memory and operands of one thread for some fields of one wavelength at a time.
class MatrixDft {
  public:
    MatrixDft(const Pupil &pupil, size_t rows, size_t cols, size_t fields);

    // Transforms the fields of a star at offset[x, y] px: step is the phase in cycles of one pupil sample times one
    // pixel, (D/N) p/lambda; terms as in kernels/field.hpp, one less than the fields.
    void transform(long double wavenumber, long double step, const long double *offset,
                   const std::vector<kernels::FieldTerm> &terms) noexcept;

    // Adds products of the focal fields to images [rows][cols].
    void accumulate(const std::vector<kernels::FieldProduct> &products, double *const *images) noexcept;

  private:
    void along_x(const Buffer<double> &folded, const Buffer<double> &operand, Buffer<double> &middle) noexcept;
    void along_y(const Buffer<double> &middle, size_t part, const Buffer<double> &operand,
                 Buffer<double> &sums) noexcept;

    const Pupil &pupil_;
    size_t rows_, cols_, fields_;
    std::vector<size_t> reach_; // of each folded row: its samples up to the last one with light
    Buffer<double> tilt_x_, tilt_y_;
    Buffer<double> cosine_x_, sine_x_, cosine_y_, sine_y_;
    Buffer<double> even_, odd_;               // folded fields, parts even and odd in x
    Buffer<double> even_middle_, odd_middle_; // transformed along x
    Buffer<double> ee_, eo_, oe_, oo_;        // transformed along y
    Buffer<double> scratch_;
};

} // namespace toliman::optics
