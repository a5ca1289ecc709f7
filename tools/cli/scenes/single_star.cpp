#include "scenes/single_star.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/scene_json.hpp"

namespace cli {

namespace {

constexpr double kPhotons = 1e9; // of the star: far above the least that a scene may have

Json band_of(const SingleStar &star) {
    constexpr double most_steps = 1000;
    Json band;
    const double width = star.max_nm - star.min_nm, steps = std::min(std::ceil(width), most_steps);
    if (width > 0)
        band.set("min_nm", star.min_nm).set("max_nm", star.max_nm).set("step_nm", width / steps);
    else
        band.set("wavelength_nm", star.min_nm);
    return band;
}

Json signal_of(double amplitude_px) {
    constexpr double half_pi = 1.5707963267948966; // the one frame has the largest displacement
    Json signal;
    signal.set("kind", "sinusoid").set("star", "A").set("amplitude_px", amplitude_px);
    signal.set("period_days", 1.0).set("phase_rad", half_pi);
    return signal;
}

std::vector<double> fractions(std::vector<double> image) {
    for (double &pixel : image)
        pixel /= kPhotons;
    return image;
}

} // namespace

Scene single_star(const std::string &path, const cJSON *telescope, const SingleStar &star) {
    Json json, stars, a, spectrum, cadence, detector;
    spectrum.set("kind", "blackbody").set("temperature_k", 5790.0);
    a.set("spectrum", std::move(spectrum)).set("photons_per_s", kPhotons);
    stars.set("A", std::move(a));
    cadence.set("frames", 1.0).set("exposure_s", 1.0);
    detector.set("shape", std::vector<size_t>{star.side, star.side}).set("pixel_scale_arcsec", star.pixel_scale_arcsec);
    json.set("schema", "toliman-scene/1").set("telescope", copy_of(telescope)).set("band", band_of(star));
    json.set("stars", std::move(stars)).set("cadence", std::move(cadence)).set("detector", std::move(detector));
    if (star.amplitude_px > 0)
        json.set("signal", signal_of(star.amplitude_px));
    return {path, json.set("accuracy", star.accuracy).text()};
}

std::vector<double> light_fractions(const Scene &star) {
    return fractions(star.image(TOLIMAN_SIM_IMAGE_BOTH));
}

std::vector<double> light_fractions(const Scene &star, double displacement_px, bool exact) {
    std::vector<double> image(star.pixels());
    toliman::check((exact ? toliman_sim_propagate : toliman_sim_expect)(star.sim.get(), displacement_px, image.data(),
                                                                        static_cast<size_t>(star.info.cols)));
    return fractions(std::move(image));
}

} // namespace cli
