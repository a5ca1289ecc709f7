// Images of a star on the detector's pixels: engine, wavelengths and pixel filter as planned.
#pragma once
#include "optics/plan.hpp"

namespace toliman::optics {

class Imager {
  public:
    // scene, pupil and plan must outlive the imager; workers > 0.
    Imager(const Scene &scene, const Pupil &pupil, const Plan &plan, unsigned workers)
        : scene_(scene), pupil_(pupil), plan_(plan), workers_(workers) {}

    // The same imager with this number of workers, or with this plan, which must outlive it.
    Imager with_workers(unsigned workers) const noexcept { return {scene_, pupil_, plan_, workers}; }
    Imager with_plan(const Plan &plan) const noexcept { return {scene_, pupil_, plan, workers_}; }

    // As propagate(), for the scene's light and on the detector's pixels. on_progress as in propagate().
    StarImages images(const Light &light, size_t star, double displacement_px, const ImageRequest &request,
                      const std::function<void(double)> &on_progress = nullptr) const;

    // The same with every wavelength of `light` propagated as given.
    StarImages images_of_samples(const Light &light, size_t star, double displacement_px, const ImageRequest &request,
                                 const std::function<void(double)> &on_progress = nullptr) const;

    // The images that star 0 would have with each of these spectra, [spectrum][wavelength] in photons, at the
    // wavelengths of `light`.
    std::vector<StarImages> images_of_spectra(const Light &light, const std::vector<std::vector<double>> &spectra,
                                              const ImageRequest &request,
                                              const std::function<void(double)> &on_progress = nullptr) const;

    // The derivative of sum over pixels of weights [rows][cols] times images().at(0, 0), without displacement, by the
    // OPD of each pupil cell (m), [N][N]. Matrix DFT only.
    Buffer<double> opd_gradient(const Light &light, size_t star, const Buffer<double> &weights) const;

    // The same of the sum over `spectra` of weights[k] times the image that star 0 would have with spectra[k], in
    // photons at the wavelengths of `light`.
    Buffer<double> opd_gradient_of_spectra(const Light &light, const std::vector<std::vector<double>> &spectra,
                                           const std::vector<Buffer<double>> &weights) const;

    // The derivative of the sum of `image`, `along`, `across` and `focus`, each the weights [rows][cols] of the image
    // of images().at(0, 0), at(1, 0), at(0, 1) and focus, by the covered fraction of each mixed cell of the pupil.
    // Matrix DFT only.
    Buffer<double> coverage_gradient(const Light &light, size_t star, const Buffer<double> &image,
                                     const Buffer<double> &along, const Buffer<double> &across,
                                     const Buffer<double> &focus) const;

  private:
    Grid grid() const noexcept;
    double finer() const noexcept;
    Buffer<double> weights_at_samples(const Buffer<double> &weights) const;
    std::unique_ptr<Transform> transform(const Grid &grid, size_t fields) const;
    void to_pixels(StarImages &images) const;

    const Scene &scene_;
    const Pupil &pupil_;
    const Plan &plan_;
    unsigned workers_;
};

} // namespace toliman::optics
