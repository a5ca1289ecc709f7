// The chapter's engine, kept as a baseline: the pupil is sampled with N_E = N_out d_pix D / (lambda f) cells, embedded
// in N_out x N_out zeros and transformed by an FFT. N_E must be whole, so every wavelength has a plate scale of its
// own.
#pragma once
#include "backend/fft.hpp"
#include "optics/transform.hpp"

namespace toliman::optics {

class PaddedFft : public Transform {
  public:
    PaddedFft(const Scene &scene, const Grid &grid, size_t fields); // scene outlives it

    const Pupil &pupil(long double wavenumber) override;
    void transform(long double wavenumber, const long double *offset,
                   const std::vector<kernels::FieldTerm> &terms) override;
    void accumulate(const std::vector<kernels::FieldProduct> &products, double *const *images) noexcept override;

  private:
    void keep_pixels(size_t field) noexcept;

    const Scene &scene_;
    Grid grid_;
    size_t side_; // N_out
    fft::Square fft_;
    Pupil pupil_;
    std::vector<Buffer<std::complex<double>>> fields_, focal_;
};

// N_out of a grid, and N_E of a wavenumber (1/m).
size_t padded_side(const Grid &grid) noexcept;
size_t embedded_samples(const Scene &scene, const Grid &grid, double wavenumber) noexcept;

// Relative error of the plate scale that each wavelength gets: images are this much larger than they should be.
std::vector<double> plate_scale_errors(const Scene &scene, const Grid &grid, const std::vector<double> &wavelength_m);

} // namespace toliman::optics
