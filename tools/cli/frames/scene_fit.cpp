#include "frames/scene_fit.hpp"

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

toliman::frame_fit make_fit(const std::string &list, const std::vector<const Scene *> &scenes,
                            const std::vector<double> &starts, const std::string &free, Progress &progress) {
    const StopLimit limit;
    auto options = with_progress<toliman_fit_options>(progress);
    options.free = free.c_str();
    std::vector<const toliman_sim *> sims;
    for (const Scene *scene : scenes)
        sims.push_back(scene->sim.get());
    toliman_fit *made = nullptr;
    const toliman_status status = toliman_fit_create(sims.data(), starts.data(), sims.size(), &options, &made);
    if (status != TOLIMAN_OK) {
        const toliman::error error(status);
        refuse_option(error, {{"free", "--free"}});
        if (error.field().rfind("sims[", 0) == 0 || error.field().rfind("first_days[", 0) == 0)
            refuse_windows(list, error);
        throw error;
    }
    return toliman::frame_fit(made);
}

// The scenes of all windows but the first, without warnings: a calibration is incomplete in all of them.
std::vector<Scene> further_scenes(const std::vector<WindowScene> &windows, const std::string &bad_pixels,
                                  Progress &progress) {
    std::vector<Scene> scenes;
    for (size_t i = 1; i < windows.size(); i++)
        scenes.push_back(scene_with(log_news, windows[i].scene, progress, bad_pixels));
    return scenes;
}

toliman::frame_fit make_fit(const std::string &list, const Scene &first, const std::vector<WindowScene> &windows,
                            const std::string &free, const std::string &bad_pixels, Progress &progress) {
    const std::vector<Scene> further = further_scenes(windows, bad_pixels, progress);
    std::vector<const Scene *> scenes = {&first};
    std::vector<double> starts;
    for (const Scene &scene : further)
        scenes.push_back(&scene);
    for (const WindowScene &window : windows)
        starts.push_back(window.first_days);
    return make_fit(list, scenes, starts, free, progress);
}

bool is_calibrated(const Scene &scene) {
    return scene.info.calibration != TOLIMAN_SIM_CALIBRATION_NONE;
}

std::string free_of(const std::string &given, bool self_by_default) {
    return given == "none" ? "" : given.empty() && self_by_default ? "self" : given;
}

} // namespace

Scene scene_to_fit(const std::string &file, Progress &progress, const std::string &bad_pixels) {
    return scene_with(log_calibration, file, progress, bad_pixels);
}

Scene scene_to_calibrate(const std::string &file, Progress &progress, const std::string &bad_pixels) {
    return scene_with(log_news, file, progress, bad_pixels);
}

SceneFit::SceneFit(const std::string &file, const std::string &free, const std::string &bad_pixels, Progress &progress,
                   bool self_by_default)
    : SceneFit(file, windows_of(file), free, bad_pixels, progress, self_by_default) {}

SceneFit::SceneFit(const std::string &file, const std::vector<WindowScene> &windows, const std::string &free,
                   const std::string &bad_pixels, Progress &progress, bool self_by_default)
    : scene(scene_to_fit(windows[0].scene, progress, bad_pixels)),
      fit(make_fit(file, scene, windows, free_of(free, self_by_default && is_calibrated(scene)), bad_pixels,
                   progress)) {}

} // namespace cli
