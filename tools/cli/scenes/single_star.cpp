#include "scenes/single_star.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/scene_json.hpp"

namespace cli {

namespace {

constexpr double kPhotons = 1e9; // of the star: far above the least that a scene may have

Json band_of(const SingleStar &star) {
    constexpr double most_steps = 1000;
    const double width = star.max_nm - star.min_nm, steps = std::min(std::ceil(width), most_steps);
    return width > 0 ? Json("min_nm", star.min_nm, "max_nm", star.max_nm, "step_nm", width / steps)
                     : Json("wavelength_nm", star.min_nm);
}

Json signal_of(double amplitude_px) {
    constexpr double half_pi = 1.5707963267948966; // the one frame has the largest displacement
    return Json("kind", "sinusoid", "star", "A", "amplitude_px", amplitude_px, "period_days", 1.0, "phase_rad",
                half_pi);
}

std::vector<double> fractions(std::vector<double> image) {
    for (double &pixel : image)
        pixel /= kPhotons;
    return image;
}

} // namespace

Scene single_star(const std::string &path, const cJSON *telescope, const SingleStar &star) {
    const std::vector<size_t> shape = {star.side, star.side};
    Json a("spectrum", Json("kind", "blackbody", "temperature_k", 5790.0), "photons_per_s", kPhotons);
    Json json("schema", "toliman-scene/1", "telescope", copy_of(telescope), "band", band_of(star), "stars",
              Json("A", std::move(a)), "cadence", Json("frames", 1.0, "exposure_s", 1.0), "detector",
              Json("shape", shape, "pixel_scale_arcsec", star.pixel_scale_arcsec));
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
