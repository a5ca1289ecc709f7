#include "scenes/masked_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "common/library.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

constexpr double kCoarseSteps = 5; // of the band

toliman_sim_info info_of(const toliman_sim *sim) {
    return info_from<toliman_sim_info>(toliman_sim_get_info, sim);
}

// Half of the middle wavelength in nm: the phase step of pi of an ideal mask.
double half_wave_nm(const toliman_sim *sim) {
    std::vector<double> wavelength(static_cast<size_t>(info_of(sim).wavelengths));
    toliman::check(toliman_sim_get_spectrum(sim, wavelength.size(), wavelength.data(), nullptr, nullptr));
    const auto [least, most] = std::minmax_element(wavelength.begin(), wavelength.end());
    return std::nearbyint((*least + *most) / 4 * 1e10) / 10;
}

} // namespace

Score score_of(const toliman_sim *sim) {
    const toliman_sim_info info = info_of(sim);
    const auto samples = static_cast<size_t>(info.wavelengths);
    std::vector<double> a(samples), b(samples);
    toliman::check(toliman_sim_get_spectrum(sim, samples, nullptr, a.data(), b.data()));
    const double emitted = std::accumulate(a.begin(), a.end(), 0.0) + std::accumulate(b.begin(), b.end(), 0.0);
    const double mean = info.total_photons / static_cast<double>(info.rows * info.cols);
    return {info.crb_px, info.peak_photons / mean, info.total_photons / emitted};
}

MaskedScene::MaskedScene(const std::string &path, const toliman_sim *sim)
    : scene_(read_scene_json(path)), folder_(folder_of(path)) {
    for (const char *name : {"opd_nm", "height_nm"}) {
        const cJSON *step = item_of(own_mask(), name);
        if (step == nullptr)
            continue;
        step_ = name;
        step_nm_ = step->valuedouble;
    }
    if (step_nm_ == 0)
        step_nm_ = half_wave_nm(sim);
}

MaskedScene::MaskedScene(const MaskedScene &other)
    : scene_(cJSON_Duplicate(other.scene_.get(), 1)), folder_(other.folder_), step_(other.step_),
      step_nm_(other.step_nm_) {}

const cJSON *MaskedScene::own_mask() const noexcept {
    return item_of(item_of(scene_.get(), "telescope"), "mask");
}

JsonTree MaskedScene::mask(const Terms &terms) const {
    JsonTree mask(cJSON_CreateObject());
    cJSON_AddStringToObject(mask.get(), "kind", "spiral");
    put(mask.get(), step_.c_str(), step_nm_);
    put(mask.get(), "terms", json_of(terms));
    return mask;
}

JsonTree MaskedScene::with(const Terms &terms) const {
    JsonTree scene(cJSON_Duplicate(scene_.get(), 1));
    if (!terms.empty())
        put(item_of(scene.get(), "telescope"), "mask", mask(terms));
    return scene;
}

Score MaskedScene::evaluate(const Terms &terms) const {
    const std::string text = text_of(with(terms));
    auto options = toliman::sized<toliman_sim_options>();
    options.threads = 1;
    const toliman::simulator sim =
        toliman::make<toliman::simulator>(toliman_sim_create_json, text.data(), text.size(), folder_.c_str(), &options);
    return score_of(sim.get());
}

MaskedScene MaskedScene::without_signal() const {
    MaskedScene quiet(*this);
    const cJSON *signal = item_of(scene_.get(), "signal");
    if (signal == nullptr)
        return quiet;
    JsonTree still(cJSON_CreateObject());
    cJSON_AddStringToObject(still.get(), "kind", "sinusoid");
    if (item_of(signal, "star") != nullptr)
        put(still.get(), "star", JsonTree(cJSON_Duplicate(item_of(signal, "star"), 1)));
    put(still.get(), "amplitude_px", 0);
    put(still.get(), "period_days", 1);
    put(quiet.scene_.get(), "signal", std::move(still));
    return quiet;
}

MaskedScene MaskedScene::coarse() const {
    MaskedScene few_wavelengths(*this);
    cJSON *band = item_of(few_wavelengths.scene_.get(), "band");
    const cJSON *step = item_of(band, "step_nm");
    if (step != nullptr) {
        const double width = item_of(band, "max_nm")->valuedouble - item_of(band, "min_nm")->valuedouble;
        put(band, "step_nm", std::max(step->valuedouble, width / kCoarseSteps));
    }
    MaskedScene half(few_wavelengths);
    cJSON *telescope = item_of(half.scene_.get(), "telescope");
    const cJSON *samples = item_of(telescope, "pupil_samples");
    put(telescope, "pupil_samples", std::floor((samples != nullptr ? samples->valuedouble : 256) / 2));
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
