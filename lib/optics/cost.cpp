// Method: operation counts of the products, transforms, images and interpolations, over rates measured on one core.
// Interpolation of a row sums T rows at o samples per pixel, then T samples per pixel (atlas.cpp).
#include "optics/cost.hpp"

#include <algorithm>
#include <cmath>

#include "backend/blas.hpp"
#include "optics/padded_fft.hpp"

namespace toliman::optics {

namespace {

// Operations per pupil cell and per pixel in addition to the matrix products, and rates of one core of a 2020s server.
// The estimate is a guide only.
constexpr double kFieldFlops = 60, kImageFlops = 12;                                 // per cell, per pixel
constexpr double kElementRate = 4e10;                                                // flop/s of these
constexpr double kPaddedRate = 3;                                                    // GFLOP/s of the padded FFT
constexpr double kInterpolationRate = 1.6e10;                                        // flop/s
constexpr double kTermSeconds = 0.3e-9, kPoissonSeconds = 7e-9, kReadSeconds = 7e-9; // per pixel
constexpr double kPupilMaps = 3;                                                     // of a pupil
constexpr double kStarFields = 4;   // the image, its two slopes and focus
constexpr double kFrameImages = 11; // in memory in addition to higher derivatives by displacement and to the atlas
constexpr double kAtlasFrameImages =
    5; // the same where frames need no derivatives: both stars, their sum, its variance, a frame

// Images of a grid: samples, matrix products or transforms, and filter of one of them.
class ImageCost {
  public:
    ImageCost(const Pupil &pupil, const Plan &plan, const Grid &pixels, const PixelFilter &filter)
        : plan_(plan), padded_(plan.engine == EngineKind::padded_fft), mixed_(!pupil.mixed.empty()) {
        const Grid grid = sampling_grid(pixels, filter);
        n_ = static_cast<double>(pupil.samples);
        samples_ = static_cast<double>(grid.rows * grid.cols);
        cols_ = static_cast<double>(grid.cols);
        side_ = static_cast<double>(padded_side(grid));
        const auto rows = static_cast<double>(grid.rows);
        // Matrix DFT: 8 N cols (N + rows) flops, folded to a quarter; a fifth of the first product lies outside the
        // round pupil and is skipped.
        const double transform = padded_ ? 10 * side_ * side_ * std::log2(side_) : n_ * cols_ * (1.6 * n_ + 2 * rows);
        const auto wavelengths = static_cast<double>(plan.wavelengths);
        products_ = wavelengths * transform + (filter.empty() ? 0 : 3 * static_cast<double>(filter.taps()) * samples_);
        elements_ = wavelengths * (kFieldFlops * n_ * n_ + kImageFlops * samples_);
    }

    double flops() const noexcept { return products_ + elements_; }
    double seconds(double rate) const noexcept { return products_ / rate + elements_ / kElementRate; }

    // Numbers in memory while `images` images are propagated at once: the sum, and of each busy worker its images and
    // pupil fields.
    double work_space(double images) const noexcept {
        const auto chunks = static_cast<double>(std::min(plan_.wavelengths, kWavelengthChunks));
        const double busy = std::min(static_cast<double>(plan_.workers), chunks);
        const double field = 2 * n_ * n_ + 2 * samples_ + (padded_ ? 0 : 2 * n_ * cols_) + (mixed_ ? 2 * n_ * n_ : 0);
        return images * ((1 + busy) * samples_ + busy * field) + (padded_ ? 2 * busy * side_ * side_ : 0);
    }

  private:
    const Plan &plan_;
    bool padded_, mixed_;
    double n_, samples_, cols_, side_, products_, elements_;
};

// The atlas of a scene; nothing if its frames do not use one.
struct AtlasCost {
    double flops = 0, seconds = 0; // of all stars
    double numbers = 0, work_space = 0;
};

AtlasCost atlas_cost(const Scene &scene, const Pupil &pupil, const Plan &plan, double rate) {
    AtlasCost cost;
    if (plan.frames != Frames::atlas)
        return cost;
    for (size_t star = 0; star < scene.stars.size(); star++) {
        const Grid grid = atlas_grid(plan, plan.atlas.reach[star]);
        const ImageCost image(pupil, plan, grid, plan.atlas.filter);
        cost.flops += image.flops();
        cost.seconds += image.seconds(rate);
        cost.numbers += static_cast<double>(grid.rows * grid.cols);
        cost.work_space = std::max(cost.work_space, image.work_space(1));
    }
    return cost;
}

// Flops per pixel of the expected image of a frame from the atlas.
double interpolation_flops(const Plan &plan, double stars) noexcept {
    const auto taps = static_cast<double>(plan.atlas.blur.window.taps);
    const auto finer = static_cast<double>(plan.atlas.oversampling);
    return stars * (finer * 2 * taps + 2 * taps);
}

} // namespace

Cost cost_of(const Scene &scene, const Pupil &pupil, const Plan &plan) {
    const double rate = 1e9 * (plan.engine == EngineKind::padded_fft ? kPaddedRate : blas::measure_tile_gflops());
    const ImageCost image(pupil, plan, plan.pixels, plan.filter);
    const AtlasCost atlas = atlas_cost(scene, pupil, plan, rate);
    const bool moves = scene.systematics.any() || scene.binary.moving;
    const auto pixels = static_cast<double>(plan.pixels.rows * plan.pixels.cols);
    const auto stars = static_cast<double>(scene.stars.size()), order = static_cast<double>(plan.order);
    const double fields = order + stars * (1 + kStarFields); // the images first, then all derivatives

    Cost cost;
    cost.setup_flops = fields * image.flops() + atlas.flops;
    cost.setup_s = fields * image.seconds(rate) + atlas.seconds;
    double at_once = 1, frame = 0; // images propagated together, and numbers in memory
    switch (plan.frames) {
    case Frames::series:
        at_once = order + 2; // with the first omitted order
        cost.frame_flops = 2 * order * pixels;
        cost.frame_s = kTermSeconds * order * pixels;
        break;
    case Frames::atlas:
        cost.frame_flops = interpolation_flops(plan, stars) * pixels;
        cost.frame_s = cost.frame_flops / kInterpolationRate;
        break;
    case Frames::propagation:
        Plan of_frame = plan;
        of_frame.workers = moves ? 1 : plan.workers; // of a frame
        const double moving = moves ? stars : 1;
        cost.frame_flops = moving * image.flops();
        cost.frame_s = moving * image.seconds(rate);
        frame = ImageCost(pupil, of_frame, plan.pixels, plan.filter).work_space(1) +
                (scene.systematics.changes_optics() ? kPupilMaps * static_cast<double>(pupil.amplitude.size()) : 0);
        break;
    }
    const double images = plan.frames == Frames::atlas ? kAtlasFrameImages : kFrameImages + order;
    const double kept = kPupilMaps * static_cast<double>(pupil.amplitude.size()) + pixels * images + atlas.numbers;
    const double frames = static_cast<double>(plan.workers) * (pixels + frame);
    cost.bytes = sizeof(double) * (kept + std::max({image.work_space(at_once), atlas.work_space, frames}));
    cost.frame_s += pixels * ((scene.noise.photon ? kPoissonSeconds : 0) + (scene.noise.read_e > 0 ? kReadSeconds : 0));
    return cost;
}

} // namespace toliman::optics
