#include "scenes/masked_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "common/text.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

constexpr double kCoarseSteps = 5; // of the band

// Half of the middle wavelength in nm: the phase step of pi of an ideal mask.
double half_wave_nm(const Scene &scene) {
    const std::vector<double> wavelength = scene.wavelengths();
    const auto [least, most] = std::minmax_element(wavelength.begin(), wavelength.end());
    return std::nearbyint((*least + *most) / 4 * 1e10) / 10;
}

} // namespace

Score score_of(const Scene &scene) {
    const toliman_sim_info &info = scene.info;
    const auto samples = static_cast<size_t>(info.wavelengths);
    std::vector<double> a(samples), b(samples);
    toliman::check(toliman_sim_get_spectrum(scene.sim.get(), samples, nullptr, a.data(), b.data()));
    const double emitted = std::accumulate(a.begin(), a.end(), 0.0) + std::accumulate(b.begin(), b.end(), 0.0);
    const double mean = info.total_photons / static_cast<double>(info.rows * info.cols);
    return {info.crb_px, info.peak_photons / mean, info.total_photons / emitted};
}

MaskedScene::MaskedScene(const Scene &scene) : scene_(read_scene_json(scene.path)), path_(scene.path) {
    for (const char *name : {"opd_nm", "height_nm"}) {
        const cJSON *step = item_of(own_mask(), name);
        if (step == nullptr)
            continue;
        step_ = name;
        step_nm_ = step->valuedouble;
    }
    if (step_nm_ == 0)
        step_nm_ = half_wave_nm(scene);
}

MaskedScene::MaskedScene(const MaskedScene &other)
    : scene_(copy_of(other.scene_.get())), path_(other.path_), step_(other.step_), step_nm_(other.step_nm_) {}

const cJSON *MaskedScene::own_mask() const noexcept {
    return item_of(item_of(scene_.get(), "telescope"), "mask");
}

JsonTree MaskedScene::mask(const Terms &terms) const {
    Json mask;
    return mask.set("kind", "spiral").set(step_.c_str(), step_nm_).set("terms", json_of(terms)).release();
}

JsonTree MaskedScene::with(const Terms &terms) const {
    JsonTree scene = copy_of(scene_.get());
    cJSON *telescope = item_of(scene.get(), "telescope");
    if (terms.empty())
        return scene;
    cJSON_DeleteItemFromObjectCaseSensitive(telescope, "mask");
    cJSON_AddItemToObject(telescope, "mask", mask(terms).release());
    return scene;
}

Score MaskedScene::evaluate(const Terms &terms) const {
    return score_of(Scene(path_, text_of(with(terms)), 1));
}

MaskedScene MaskedScene::without_signal() const {
    MaskedScene quiet(*this);
    const cJSON *signal = item_of(scene_.get(), "signal"), *star = item_of(signal, "star");
    if (signal == nullptr)
        return quiet;
    merge(quiet.scene_.get(), R"({"signal": null})");
    merge(quiet.scene_.get(),
          formatted(R"({"signal": {"kind": "sinusoid", "star": %s, "amplitude_px": 0, "period_days": 1}})",
                    star != nullptr ? line_of(star).c_str() : "null"));
    return quiet;
}

MaskedScene MaskedScene::coarse() const {
    MaskedScene few_wavelengths(*this);
    const cJSON *band = item_of(scene_.get(), "band"), *step = item_of(band, "step_nm");
    if (step != nullptr) {
        const double width = item_of(band, "max_nm")->valuedouble - item_of(band, "min_nm")->valuedouble;
        merge(few_wavelengths.scene_.get(),
              formatted(R"({"band": {"step_nm": %.17g}})", std::max(step->valuedouble, width / kCoarseSteps)));
    }
    MaskedScene half(few_wavelengths);
    const cJSON *samples = item_of(item_of(scene_.get(), "telescope"), "pupil_samples");
    merge(half.scene_.get(), formatted(R"({"telescope": {"pupil_samples": %.17g}})",
                                       std::floor((samples != nullptr ? samples->valuedouble : 256) / 2)));
    return half.accepted() ? half : few_wavelengths;
}

// Whether the library accepts the scene: with too few samples the image aliases, and files of the pupil have a fixed
// size.
bool MaskedScene::accepted() const {
    try {
        evaluate(draw_terms(0, 0));
        return true;
    } catch (const toliman::error &error) {
        if (error.status() == TOLIMAN_E_SCENE || error.status() == TOLIMAN_E_FORMAT)
            return false;
        throw;
    }
}

} // namespace cli
