#include "frames/scene_fit.hpp"

#include "common/content.hpp"
#include "scenes/dates.hpp"

namespace cli {

namespace {

void log_news(int32_t level, const char *text, void *progress) {
    if (level != TOLIMAN_LOG_WARNING)
        Progress::log(level, text, progress);
}

// Texts of lib/optics/warnings.cpp.
void log_calibration(int32_t level, const char *text, void *progress) {
    if (level != TOLIMAN_LOG_WARNING || std::string(text).find(": its calibration ") != std::string::npos)
        Progress::log(level, text, progress);
}

Scene scene_with(toliman_log_fn log, const std::string &file, Progress &progress, const std::string &bad_pixels) {
    auto options = toliman::sized<toliman_sim_options>();
    options.progress = Progress::callback;
    options.progress_data = options.log_data = &progress;
    options.log = log;
    options.bad_pixels = bad_pixels.empty() ? nullptr : bad_pixels.c_str();
    return Scene(file, options);
}

// An error of a scene or a start of a list, in terms of its file.
[[noreturn]] void refuse_windows(const std::string &list, const toliman::error &error) {
    const bool of_scene = error.field().rfind("sims[", 0) == 0 && error.detail().rfind(": ", 0) == 0;
    malformed(list, of_scene ? error.detail().substr(2) : error.what());
}

toliman::frame_fit make_fit(const std::string &list, const std::vector<const toliman_sim *> &sims,
                            const std::vector<double> &starts, const std::string &free, Progress &progress) {
    const StopLimit limit;
    auto options = with_progress<toliman_fit_options>(progress);
    options.free = free.c_str();
    try {
        return toliman::make<toliman::frame_fit>(toliman_fit_create, sims.data(), starts.data(), sims.size(), &options);
    } catch (const toliman::error &error) {
        refuse_option(error, {{"free", "--free"}});
        if (error.field().rfind("sims[", 0) == 0 || error.field().rfind("first_days[", 0) == 0)
            refuse_windows(list, error);
        throw;
    }
}

std::string free_of(const std::string &given, bool self_by_default) {
    return given == "none" ? "" : given.empty() && self_by_default ? "self" : given;
}

// Those options of the training that are not the defaults.
std::string training_text(const toliman_bank_info &info) {
    std::string text;
    if (const long places = std::lround(std::sqrt(static_cast<double>(info.places))); places != 3)
        text += formatted(" --places %ld", places);
    if (info.spacing_px != 0.5)
        text += formatted(" --spacing %g", info.spacing_px);
    if (info.steps != 600)
        text += formatted(" --steps %u", info.steps);
    if (info.layout != std::string("flight"))
        text += std::string(" --layout ") + info.layout;
    return text;
}

} // namespace

Scene scene_to_calibrate(const std::string &file, Progress &progress, const std::string &bad_pixels) {
    return scene_with(log_news, file, progress, bad_pixels);
}

SceneFit fit_of_scene(const std::string &file, const std::string &free, const std::string &bad_pixels,
                      Progress &progress, bool self_by_default) {
    std::vector<Scene> scenes;
    std::vector<const toliman_sim *> sims;
    std::vector<double> starts;
    for (const WindowScene &window : windows_of(file)) {
        // One warning: a calibration is incomplete in all windows.
        scenes.push_back(scene_with(scenes.empty() ? log_calibration : log_news, window.scene, progress, bad_pixels));
        sims.push_back(scenes.back().sim.get());
        starts.push_back(window.first_days);
    }
    const bool is_calibrated = scenes[0].info.calibration != TOLIMAN_SIM_CALIBRATION_NONE;
    toliman::frame_fit fit = make_fit(file, sims, starts, free_of(free, self_by_default && is_calibrated), progress);
    return {std::move(scenes[0]), std::move(fit)};
}

toliman::network_bank trained_bank(const std::string &path) {
    need(path, "a bank of toliman networks", {Content::bank});
    auto bank = toliman::make<toliman::network_bank>(toliman_bank_load_file, path.c_str(), nullptr);
    const auto info = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank.get());
    if (info.trained_networks < info.networks)
        malformed(path,
                  formatted("contains an interrupted training, %lld of %lld networks: continue it with `toliman "
                            "train --resume`",
                            static_cast<long long>(info.trained_networks), static_cast<long long>(info.networks)));
    return bank;
}

void check_bank(const toliman::network_bank &bank, const toliman::frame_fit &fit, const std::string &path,
                const std::string &scene, const std::string &free) {
    auto undisturbed = toliman::sized<toliman_bank_result>();
    const toliman_status status = toliman_bank_predict(bank.get(), fit.get(), nullptr, &undisturbed);
    if (status == TOLIMAN_E_MISMATCH)
        throw Failure(kExitUsage, path + ": was trained for another scene or other free parameters than " + scene +
                                      free_text(free) + ": give scene and --free of the training");
    toliman::check(status);
}

std::string free_text(const std::string &free) {
    return free.empty() ? "" : " --free \"" + free + "\"";
}

double efficiency_at(const toliman::network_bank &bank, const toliman::frame_fit &fit, double days) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.time_days = days;
    auto undisturbed = toliman::sized<toliman_bank_result>();
    toliman::check(toliman_bank_predict(bank.get(), fit.get(), &prediction, &undisturbed));
    return undisturbed.efficiency;
}

std::string use_of(const toliman::network_bank &bank, const toliman::frame_fit &fit, const Scene &scene) {
    const std::optional<double> zero = date_of(scene);
    if (!zero)
        return "";
    const double last = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank.get()).last_days,
                 efficiency = efficiency_at(bank, fit, last);
    if (efficiency < kLeastEfficiency)
        return formatted("an efficiency of %.3f on its last day, %s", efficiency, day_text(*zero, last).c_str());
    double days = 0;
    toliman::check(toliman_bank_get_renewal(bank.get(), fit.get(), kLeastEfficiency, &days));
    return formatted("an efficiency of at least %g until %s", kLeastEfficiency, day_text(*zero, days).c_str());
}

std::string renewal_of(const toliman::network_bank &bank, const toliman::frame_fit &fit, const Scene &scene,
                       const std::string &file, const std::string &free) {
    const std::optional<double> zero = date_of(scene);
    if (!zero)
        return "";
    const auto info = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank.get());
    const double next = 2 * info.last_days - info.first_days;
    return formatted("the bank has %s; train the next one with: toliman train %s --bank %s:%s%s%s --out FILE",
                     use_of(bank, fit, scene).c_str(), file.c_str(), day_text(*zero, info.last_days).c_str(),
                     day_text(*zero, next).c_str(), training_text(info).c_str(), free_text(free).c_str());
}

} // namespace cli
