#include "experiment/variants.hpp"

#include <cmath>
#include <vector>

#include "common/failure.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

double middle_wavelength_nm(const Scene &scene) {
    std::vector<double> wavelength(static_cast<size_t>(scene.info.wavelengths));
    toliman::check(toliman_sim_get_spectrum(scene.sim.get(), wavelength.size(), wavelength.data(), nullptr, nullptr));
    return wavelength[wavelength.size() / 2] * 1e9;
}

void project_fluxes_and_shifts(cJSON *scene) {
    const char *names[] = {"flux_a", "flux_b", "shift_x", "shift_y"};
    put(object_of(scene, "preprocess"), "project", JsonTree(cJSON_CreateStringArray(names, 4)));
}

} // namespace

SceneVariants::SceneVariants(const Scene &scene)
    : json_(read_scene_json(scene.path)), wavelength_nm_(middle_wavelength_nm(scene)) {
    toliman::check(toliman_sim_get_offsets(scene.sim.get(), &offsets_));
    if (std::isnan(offsets_.b_x_px))
        throw Failure(kExitUsage, scene.path +
                                      ": stars.B: is missing: the tables equal and robust need two stars; give " +
                                      "--tables real");
}

std::string SceneVariants::equal_stars() const {
    JsonTree scene = copy_of(json_.get());
    cJSON *stars[] = {item_of(item_of(scene.get(), "stars"), "A"), item_of(item_of(scene.get(), "stars"), "B")};
    const cJSON *photons[] = {item_of(stars[0], "photons_per_s"), item_of(stars[1], "photons_per_s")};
    const bool counted = photons[0] != nullptr && photons[1] != nullptr;
    const double flux = counted ? (photons[0]->valuedouble + photons[1]->valuedouble) / 2 : 1;
    for (cJSON *star : stars)
        put(star, counted ? "photons_per_s" : "relative_flux", flux);
    return text_of(scene);
}

std::string SceneVariants::disturbed(bool projected) const {
    JsonTree scene = copy_of(json_.get());
    cJSON *systematics = object_of(scene.get(), "systematics");
    put(systematics, "pointing_rms_px", 1e-3);
    put(systematics, "flux_rms", 1e-4);
    if (projected)
        project_fluxes_and_shifts(scene.get());
    return text_of(scene);
}

std::string SceneVariants::projected() const {
    JsonTree scene = copy_of(json_.get());
    project_fluxes_and_shifts(scene.get());
    return text_of(scene);
}

std::string SceneVariants::defocused(double waves_rms) const {
    constexpr const char *kFocus = "4"; // Noll's index
    JsonTree scene = copy_of(json_.get());
    cJSON *zernikes = object_of(object_of(item_of(scene.get(), "telescope"), "aberrations"), "zernike_rms_nm");
    const cJSON *own = item_of(zernikes, kFocus);
    put(zernikes, kFocus, (own != nullptr ? own->valuedouble : 0) + waves_rms * wavelength_nm_);
    return text_of(scene);
}

std::string SceneVariants::moved(double separation_px, double shift_px, double scale) const {
    JsonTree scene = copy_of(json_.get());
    double places[4] = {offsets_.a_x_px / scale + shift_px, offsets_.a_y_px / scale, offsets_.b_x_px / scale + shift_px,
                        offsets_.b_y_px / scale};
    const cJSON *star = item_of(item_of(scene.get(), "signal"), "star");
    const bool b_moves = star != nullptr && std::string(star->valuestring) == "B";
    double *still = b_moves ? places : places + 2;
    const double *moving = b_moves ? places + 2 : places;
    const double x = still[0] - moving[0], y = still[1] - moving[1], distance = std::hypot(x, y);
    still[0] += x / distance * separation_px;
    still[1] += y / distance * separation_px;
    JsonTree binary(cJSON_CreateObject()), offsets(cJSON_CreateObject());
    put(offsets.get(), "A", JsonTree(cJSON_CreateDoubleArray(places, 2)));
    put(offsets.get(), "B", JsonTree(cJSON_CreateDoubleArray(places + 2, 2)));
    put(binary.get(), "offsets_px", std::move(offsets));
    const cJSON *distance_pc = item_of(item_of(scene.get(), "binary"), "distance_pc");
    if (distance_pc != nullptr)
        put(binary.get(), "distance_pc", copy_of(distance_pc));
    put(scene.get(), "binary", std::move(binary));
    cJSON *detector = item_of(scene.get(), "detector");
    put(detector, "pixel_scale_arcsec", scale * item_of(detector, "pixel_scale_arcsec")->valuedouble);
    return text_of(scene);
}

} // namespace cli
