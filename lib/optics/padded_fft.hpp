// The padded FFT engine, a baseline for comparison: the pupil in N_E x N_E cells, zero-padded to N_out x N_out.
#pragma once
#include "backend/fft.hpp"
#include "optics/transform.hpp"

namespace toliman::optics {

class PaddedFft : public Transform {
  public:
    PaddedFft(const Scene &scene, const Grid &grid, size_t fields); // scene must outlive the object

    const Pupil &pupil(long double wavenumber) override;
    void transform(long double wavenumber, const long double *offset,
                   const std::vector<kernels::FieldTerm> &terms) override;
    void accumulate(const std::vector<kernels::FieldProduct> &products, double *const *images) noexcept override;

  private:
    void crop_to_frame(size_t field) noexcept;

    const Scene &scene_;
    Grid grid_;
    size_t side_; // N_out
    fft::Square fft_;
    Pupil pupil_, resolved_; // resolved_: at the last wavenumber
    std::vector<Buffer<std::complex<double>>> fields_, focal_;
};

// N_out of a grid, and N_E of a wavenumber (1/m).
size_t padded_side(const Grid &grid) noexcept;
size_t embedded_samples(const Scene &scene, const Grid &grid, double wavenumber) noexcept;

// Relative error of the plate scale at each wavelength: the image is larger by this than it should be.
std::vector<double> plate_scale_errors(const Scene &scene, const Grid &grid, const std::vector<double> &wavelength_m);

} // namespace toliman::optics
