// Method: a variant is the scene's JSON with a merge patch (RFC 7386).
#include "experiment/variants.hpp"

#include <cmath>
#include <optional>
#include <vector>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

SceneVariants::SceneVariants(const Scene &scene)
    : json_(read_scene_json(scene.path)),
      wavelength_nm_(scene.wavelengths()[static_cast<size_t>(scene.info.wavelengths) / 2] * 1e9),
      pixel_scale_arcsec_(scene.info.pixel_scale_arcsec) {
    toliman::check(toliman_sim_get_offsets(scene.sim.get(), &offsets_));
    if (std::isnan(offsets_.b_x_px))
        throw Failure(kExitUsage, scene.path +
                                      ": stars.B: is missing: the tables equal and robust need two stars; give " +
                                      "--tables real");
}

namespace {

// Photons per second of a star, given directly or by its magnitude; nothing if the star has a relative flux.
std::optional<double> photons_of(const cJSON *star) {
    const cJSON *photons = item_of(star, "photons_per_s"), *magnitude = item_of(star, "magnitude");
    if (photons != nullptr)
        return photons->valuedouble;
    if (magnitude != nullptr)
        return item_of(star, "zero_point_photons_per_s")->valuedouble * std::pow(10, -0.4 * magnitude->valuedouble);
    return std::nullopt;
}

} // namespace

std::string SceneVariants::with(const std::vector<std::string> &patches) const {
    JsonTree scene = copy_of(json_.get());
    for (const std::string &patch : patches)
        merge(scene.get(), patch);
    return text_of(scene);
}

std::string SceneVariants::equal_stars() const {
    const cJSON *stars = item_of(json_.get(), "stars");
    const std::optional<double> a = photons_of(item_of(stars, "A")), b = photons_of(item_of(stars, "B"));
    const bool counted = a && b;
    const std::string star = formatted(R"({"magnitude": null, "zero_point_photons_per_s": null, "%s": %.17g})",
                                       counted ? "photons_per_s" : "relative_flux", counted ? (*a + *b) / 2 : 1);
    return with({R"({"stars": {"A": )" + star + R"(, "B": )" + star + "}}"});
}

std::string SceneVariants::defocused(double waves_rms) const {
    constexpr const char *kFocus = "4"; // Noll's index
    const cJSON *aberrations = item_of(item_of(json_.get(), "telescope"), "aberrations");
    const cJSON *own = item_of(item_of(aberrations, "zernike_rms_nm"), kFocus);
    return with({formatted(R"({"telescope": {"aberrations": {"zernike_rms_nm": {"%s": %.17g}}}})", kFocus,
                           (own != nullptr ? own->valuedouble : 0) + waves_rms * wavelength_nm_)});
}

std::string SceneVariants::moved(double separation_px, double shift_px, double scale) const {
    double places[4] = {offsets_.a_x_px / scale + shift_px, offsets_.a_y_px / scale, offsets_.b_x_px / scale + shift_px,
                        offsets_.b_y_px / scale};
    const cJSON *star = item_of(item_of(json_.get(), "signal"), "star");
    const bool b_moves = star != nullptr && std::string(star->valuestring) == "B";
    double *still = b_moves ? places : places + 2;
    const double *moving = b_moves ? places + 2 : places;
    const double x = still[0] - moving[0], y = still[1] - moving[1], distance = std::hypot(x, y);
    still[0] += x / distance * separation_px;
    still[1] += y / distance * separation_px;
    const cJSON *distance_pc = item_of(item_of(json_.get(), "binary"), "distance_pc");
    return with(
        {R"({"binary": null})",
         formatted(R"({"binary": {"offsets_px": {"A": [%.17g, %.17g], "B": [%.17g, %.17g]}, "distance_pc": %s},
                               "detector": {"focal_length_m": null, "pixel_um": null,
                                            "pixel_scale_arcsec": %.17g}})",
                   places[0], places[1], places[2], places[3],
                   distance_pc != nullptr ? line_of(distance_pc).c_str() : "null", scale * pixel_scale_arcsec_)});
}

} // namespace cli
