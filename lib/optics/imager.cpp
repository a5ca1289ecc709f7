// Method: an integrated pixel is the convolution of the image with the square pixel. The image is sampled
// `oversampling` times finer per axis, with a margin, and a short filter (PixelFilter) integrates the samples over
// each pixel; the plan chooses both for the accuracy of the scene. Where every other sample determines the image
// (half_band.cpp), only these are propagated. Offsets and displacements are in units of the propagated sample
// meanwhile, so that derivatives of order n are multiplied by finer^n afterwards, and intensities by finer^2.
#include "optics/imager.hpp"

#include <cmath>

#include "base/workers.hpp"
#include "optics/gradient.hpp"
#include "optics/matrix_dft.hpp"
#include "optics/nodes.hpp"
#include "optics/padded_fft.hpp"

namespace toliman::optics {

namespace {

// Offsets in units of a pixel that is `finer` times smaller.
Light on_finer_grid(Light light, double finer) noexcept {
    for (auto &offset : light.offset_px)
        for (double &position : offset)
            position *= finer;
    for (double &by_wavelength : light.dispersion)
        by_wavelength *= finer;
    return light;
}

} // namespace

// The samples that are propagated.
Grid Imager::grid() const noexcept {
    const Grid dense = sampling_grid(plan_.pixels, plan_.filter);
    return plan_.half_band.empty() ? dense : sparse_grid(dense, plan_.half_band);
}

// Their number per pixel and axis.
double Imager::finer() const noexcept {
    return static_cast<double>(plan_.filter.oversampling) * (plan_.half_band.empty() ? 1 : 0.5);
}

std::unique_ptr<Transform> Imager::transform(const Grid &grid, size_t fields) const {
    if (plan_.engine == EngineKind::padded_fft)
        return std::make_unique<PaddedFft>(scene_, grid, fields);
    return std::make_unique<MatrixDft>(pupil_, grid, fields);
}

StarImages Imager::images(const Light &light, size_t star, double displacement_px, const ImageRequest &request,
                          const std::function<void(double)> &on_progress) const {
    return images_of_samples(plan_.nodes ? project_on_nodes(light, plan_.wavelengths) : light, star, displacement_px,
                             request, on_progress);
}

StarImages Imager::images_of_samples(const Light &light, size_t star, double displacement_px,
                                     const ImageRequest &request,
                                     const std::function<void(double)> &on_progress) const {
    const Engine engine = [this](const Grid &grid, size_t fields) { return transform(grid, fields); };
    StarImages images = propagate(engine, on_finer_grid(light, finer()), grid(), star, displacement_px * finer(),
                                  request, workers_, on_progress);
    to_pixels(images);
    return images;
}

std::vector<StarImages> Imager::images_of_spectra(const Light &light, const std::vector<std::vector<double>> &spectra,
                                                  const ImageRequest &request,
                                                  const std::function<void(double)> &on_progress) const {
    const Engine engine = [this](const Grid &grid, size_t fields) { return transform(grid, fields); };
    std::vector<StarImages> all =
        propagate(engine, on_finer_grid(light, finer()), grid(), spectra, request, workers_, on_progress);
    for (StarImages &images : all)
        to_pixels(images);
    return all;
}

// A sample holds the light of its own small area and its derivatives are per sample: scales both to whole pixels.
void Imager::to_pixels(StarImages &images) const {
    const PixelFilter &filter = plan_.filter;
    const HalfBand &half_band = plan_.half_band;
    if (filter.empty() && half_band.empty())
        return;
    struct Work {
        Buffer<double> *image;
        size_t order;
    };
    std::vector<Work> work;
    for (Derivative &derivative : images.derivatives)
        work.push_back({&derivative.image, derivative.along + derivative.across});
    for (Buffer<double> *image : {&images.focus, &images.focus_curve, &images.scale, &images.anisotropy, &images.shear})
        if (!image->empty())
            work.push_back({image, 0});
    for (Buffer<double> &mode : images.modes)
        work.push_back({&mode, 0});
    const Grid dense = sampling_grid(plan_.pixels, filter);
    std::vector<Buffer<double>> pixels(work.size(), Buffer<double>(plan_.pixels.rows * plan_.pixels.cols));
    run_jobs(workers_, work.size(), [&](size_t i) { // a worker allocates nothing that remains
        Buffer<double> made;
        const Buffer<double> *image = work[i].image;
        if (!half_band.empty())
            image = &(made = interpolated(*image, dense, half_band));
        if (!filter.empty())
            image = &(made = filtered(*image, plan_.pixels, filter));
        const double samples = std::pow(finer(), static_cast<double>(2 + work[i].order));
        for (size_t pixel = 0; pixel < pixels[i].size(); pixel++)
            pixels[i][pixel] = samples * (*image)[pixel];
    });
    for (size_t i = 0; i < work.size(); i++)
        *work[i].image = std::move(pixels[i]);
}

Buffer<double> Imager::opd_gradient(const Light &light, size_t star, const Buffer<double> &weights) const {
    const Light samples = on_finer_grid(plan_.nodes ? project_on_nodes(light, plan_.wavelengths) : light, finer());
    const Buffer<double> at_samples = weights_at_samples(weights);
    Buffer<double> gradient(pupil_.samples * pupil_.samples);
    add_opd_gradient(pupil_, samples, grid(), star, at_samples.data(), workers_, gradient.data());
    return gradient;
}

Buffer<double> Imager::opd_gradient_of_spectra(const Light &light, const std::vector<std::vector<double>> &spectra,
                                               const std::vector<Buffer<double>> &weights) const {
    const Light samples = on_finer_grid(light, finer());
    std::vector<Buffer<double>> at_samples;
    std::vector<const double *> pointers;
    for (const Buffer<double> &of_pixels : weights)
        at_samples.push_back(weights_at_samples(of_pixels));
    for (const Buffer<double> &of_samples : at_samples)
        pointers.push_back(of_samples.data());
    Buffer<double> gradient(pupil_.samples * pupil_.samples);
    add_opd_gradient(pupil_, samples, grid(), spectra, pointers, workers_, gradient.data());
    return gradient;
}

Buffer<double> Imager::coverage_gradient(const Light &light, size_t star, const Buffer<double> &image,
                                         const Buffer<double> &along, const Buffer<double> &across,
                                         const Buffer<double> &focus) const {
    const Light samples = on_finer_grid(plan_.nodes ? project_on_nodes(light, plan_.wavelengths) : light, finer());
    Buffer<double> weights[4] = {weights_at_samples(image), weights_at_samples(along), weights_at_samples(across),
                                 weights_at_samples(focus)};
    for (Buffer<double> *by_position : {&weights[1], &weights[2]}) // derivatives per sample
        for (double &weight : *by_position)
            weight *= finer();
    Buffer<double> gradient(pupil_.mixed.size());
    add_coverage_gradient(pupil_, samples, grid(), star,
                          {weights[0].data(), weights[1].data(), weights[2].data(), weights[3].data()}, workers_,
                          gradient.data());
    return gradient;
}

// A sample holds the light of its own small area.
Buffer<double> Imager::weights_at_samples(const Buffer<double> &weights) const {
    const PixelFilter &filter = plan_.filter;
    Buffer<double> at_samples = filter.empty() ? weights : spread(weights, plan_.pixels, filter);
    if (!plan_.half_band.empty())
        at_samples = spread(at_samples, sampling_grid(plan_.pixels, filter), plan_.half_band);
    for (double &weight : at_samples)
        weight *= finer() * finer();
    return at_samples;
}

} // namespace toliman::optics
