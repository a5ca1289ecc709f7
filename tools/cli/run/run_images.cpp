#include "run/run_images.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/single_star.hpp"

namespace cli {

namespace {

using toliman::check;

constexpr double kMostDisplacement = 0.1; // px, of toliman_sim_expect

struct Band {
    double min_nm, max_nm;
};
constexpr Band kChapterBands[] = {{600, 600}, {550, 600}, {500, 700}}; // of the book chapter's figure

// Coordinate of pixel `first` of a detector of `count` pixels.
double place_of(int64_t count, int64_t first = 0) {
    return static_cast<double>(first) - static_cast<double>(count - 1) / 2;
}

Band band_of(const Scene &scene) {
    const std::vector<double> waves = scene.wavelengths();
    const auto [least, greatest] = std::minmax_element(waves.begin(), waves.end());
    return {*least * 1e9, *greatest * 1e9};
}

void add_pupil(const Scene &scene, std::vector<RunImage> &images) {
    const auto side = static_cast<size_t>(scene.info.pupil_samples);
    std::vector<double> amplitude(side * side), opd(amplitude.size());
    check(toliman_sim_get_pupil(scene.sim.get(), amplitude.data(), opd.data()));
    for (size_t i = 0; i < opd.size(); i++)
        opd[i] = amplitude[i] > 0 ? opd[i] * 1e9 : NAN;
    const double step = scene.info.aperture_m * 1e3 / static_cast<double>(side);
    const double first = step * place_of(scene.info.pupil_samples);
    const std::vector<size_t> shape = {side, side};
    images.push_back({"amplitude of the pupil", "", "mm", shape, first, first, step, NAN, NAN, std::move(amplitude)});
    images.push_back({"optical path difference of mask and aberrations; NaN where no light passes", "nm", "mm", shape,
                      first, first, step, NAN, NAN, std::move(opd)});
}

// An image in pixels of the detector, still without values.
RunImage image_of(const char *what, const char *unit, const std::vector<size_t> &shape, double first_x, double first_y,
                  const Band &band) {
    return {what, unit, "px", shape, first_x, first_y, 1, band.min_nm, band.max_nm, {}};
}

// NaN if the library refuses the band, as it does where the pupil has too few samples.
RunImage point_spread(const Scene &scene, const cJSON *telescope, const Band &band) {
    constexpr double accuracy = 1e-6;
    constexpr auto side = static_cast<int64_t>(kNetworkSide);
    const SingleStar star = {band.min_nm, band.max_nm, kNetworkSide, scene.info.pixel_scale_arcsec, 0, accuracy};
    RunImage image = image_of("point spread function of a black body of 5790 K in the centre of the frame",
                              "fraction of light", {kNetworkSide, kNetworkSide}, place_of(side), place_of(side), band);
    try {
        image.values = light_fractions(single_star(scene.path, telescope, star));
    } catch (const toliman::error &error) {
        if (error.status() != TOLIMAN_E_SCENE)
            throw;
        image.values.assign(kNetworkSide * kNetworkSide, NAN);
        image.reason = error.what();
    }
    return image;
}

std::vector<double> expected(const Scene &scene, double displacement) {
    std::vector<double> image(scene.pixels());
    const auto work = std::fabs(displacement) <= kMostDisplacement ? toliman_sim_expect : toliman_sim_propagate;
    check(work(scene.sim.get(), displacement, image.data(), static_cast<size_t>(scene.info.cols)));
    return image;
}

// Frame without noise, frame 0, and the change of the former at the largest displacement.
void add_frames(const Scene &scene, const Band &band, uint64_t seed, std::vector<RunImage> &images) {
    const double low = scene.info.min_displacement_px, high = scene.info.max_displacement_px;
    std::vector<double> still = expected(scene, 0), frame(scene.pixels());
    std::vector<double> change = expected(scene, -low > high ? low : high);
    std::transform(change.begin(), change.end(), still.begin(), change.begin(), std::minus<double>());
    check(toliman_sim_frame(scene.sim.get(), nullptr, seed, 0, 1, frame.data()));
    const auto add = [&](const char *what, std::vector<double> &values) {
        images.push_back(image_of(what, unit_of(scene.info),
                                  {static_cast<size_t>(scene.info.rows), static_cast<size_t>(scene.info.cols)},
                                  place_of(scene.info.cols), place_of(scene.info.rows), band));
        images.back().values = std::move(values);
    };
    add("expected frame without displacement", still);
    add("frame 0", frame);
    add("expected frame at the largest displacement less that without", change);
}

} // namespace

const char *unit_of(const toliman_sim_info &info) {
    return info.unit == TOLIMAN_SIM_UNIT_DN ? "DN" : info.unit == TOLIMAN_SIM_UNIT_ELECTRON ? "electrons" : "photons";
}

std::vector<RunImage> run_images(const Scene &scene, const cJSON *telescope, uint64_t seed) {
    std::vector<RunImage> images;
    add_pupil(scene, images);
    for (const Band &wanted : kChapterBands)
        images.push_back(point_spread(scene, telescope, wanted));
    add_frames(scene, band_of(scene), seed, images);
    return images;
}

void add_reconstructions(const Scene &scene, Reconstructions &from, std::vector<RunImage> &images) {
    const auto row = static_cast<int64_t>(from.crop_row), col = static_cast<int64_t>(from.crop_col);
    RunImage image = image_of("", unit_of(scene.info), {from.samples.size(), kNetworkSide, kNetworkSide},
                              place_of(scene.info.cols, col), place_of(scene.info.rows, row), band_of(scene));
    const auto add = [&](const char *what, std::vector<double> &values) {
        image.what = what;
        image.values = std::move(values);
        images.push_back(image);
    };
    add("random frames, cropped as the network crops them", from.frames);
    add("what the network reconstructs of each random frame", from.reconstructions);
    image.unit = "sigma of the pixel";
    add("random frames less their reconstructions, divided by the noise of each pixel", from.residuals);
}

} // namespace cli
