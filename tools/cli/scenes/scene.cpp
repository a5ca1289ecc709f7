#include "scenes/scene.hpp"

#include <charconv>
#include <filesystem>

#include "common/content.hpp"
#include "options/suggest.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

toliman_sim_options options_with(Progress &progress, const std::string &bad_pixels) {
    auto options = with_warnings<toliman_sim_options>(progress);
    options.progress = Progress::callback;
    options.progress_data = &progress;
    options.bad_pixels = bad_pixels.empty() ? nullptr : bad_pixels.c_str();
    return options;
}

toliman::simulator simulator_of(const std::string &path, const toliman_sim_options &options) {
    const StopLimit limit;
    return toliman::make<toliman::simulator>(toliman_sim_create_file, path.c_str(), &options);
}

int64_t bound_of(const std::string &text, int64_t absent, const std::string &whole) {
    if (text.empty())
        return absent;
    int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        throw Failure(kExitUsage, "--frames " + whole + ": must be FIRST:END, e.g. 0:100");
    return value;
}

// The suggestion of a shipped scene with a similar name, also if the suffix is missing.
std::string similar_scene(const std::string &name, const std::string &folder) {
    std::vector<std::string> scenes;
    std::error_code error;
    for (const auto &entry : std::filesystem::directory_iterator(folder, error))
        if (entry.path().extension() == ".json")
            scenes.push_back(entry.path().filename().string());
    std::sort(scenes.begin(), scenes.end());
    const std::string found = did_you_mean(name, scenes);
    return found.empty() ? did_you_mean(name + ".json", scenes) : found;
}

} // namespace

std::string scene_path(const std::string &name, const toliman_sim_options &options) {
    if (exists(name) || name.find('/') != std::string::npos) {
        need(name, "a toliman scene (JSON)", {Content::scene, Content::json});
        return name;
    }
    const std::string folder = shipped_scenes();
    std::string shipped = folder + "/" + name;
    if (!exists(shipped))
        malformed(name, "No such file, nor a scene in " + folder + similar_scene(name, folder));
    if (options.log != nullptr)
        options.log(TOLIMAN_LOG_INFO, ("scene " + shipped).c_str(), options.log_data);
    return shipped;
}

std::vector<toliman_sim_stage> stages_of(const toliman_sim_plan_info &plan) {
    return all_of<toliman_sim_stage>([&](toliman_sim_stage *items, size_t capacity, size_t *count) {
        return toliman_sim_get_stages(&plan, items, capacity, count);
    });
}

bool has_stage(const toliman_sim_plan_info &plan, const std::string &name) {
    const std::vector<toliman_sim_stage> stages = stages_of(plan);
    return std::any_of(stages.begin(), stages.end(),
                       [&](const toliman_sim_stage &stage) { return stage.modelled != 0 && stage.name == name; });
}

Scene::Scene(const std::string &file, Progress &progress, const std::string &bad_pixels)
    : Scene(file, options_with(progress, bad_pixels)) {}

Scene::Scene(const std::string &file, const toliman_sim_options &options)
    : path(scene_path(file, options)), sim(simulator_of(path, options)),
      info(toliman::result<toliman_sim_info>(toliman_sim_get_info, sim.get())) {}

Scene::Scene(const std::string &file, const std::string &json)
    : path(file), sim(toliman::make<toliman::simulator>(toliman_sim_create_json, json.data(), json.size(),
                                                        folder_of(file).c_str(), nullptr)),
      info(toliman::result<toliman_sim_info>(toliman_sim_get_info, sim.get())) {}

toliman_sim_bounds Scene::bounds() const {
    return toliman::result<toliman_sim_bounds>(toliman_sim_get_bounds, sim.get());
}

std::vector<double> Scene::image(int32_t kind) const {
    std::vector<double> image(pixels());
    toliman::check(toliman_sim_get_image(sim.get(), kind, image.data(), static_cast<size_t>(info.cols)));
    return image;
}

std::vector<double> Scene::wavelengths() const {
    std::vector<double> waves(static_cast<size_t>(info.wavelengths));
    toliman::check(toliman_sim_get_spectrum(sim.get(), waves.size(), waves.data(), nullptr, nullptr, nullptr));
    return waves;
}

bool Scene::has(const char *stage) const {
    return has_stage(toliman::result<toliman_sim_plan_info>(toliman_sim_get_plan, sim.get()), stage);
}

std::string Scene::lacks_for_real_frames() const {
    const auto plan = toliman::result<toliman_sim_plan_info>(toliman_sim_get_plan, sim.get());
    const double noise = 1 / std::sqrt(info.peak_photons);
    if (!(plan.pupil_error > noise))
        return "";
    const JsonTree tree = read_scene_json(path);
    const cJSON *const edges = item_of(item_of(item_of(tree.get(), "telescope"), "mask"), "edges");
    const bool is_cell = cJSON_IsString(edges) != 0 && edges->valuestring == std::string("cell");
    return formatted("%s: the expected error of its %lld x %lld pupil cells, %.1e of the peak, exceeds the photon "
                     "noise of a frame, %.1e: frames of a real mask need %smore telescope.pupil_samples",
                     path.c_str(), static_cast<long long>(plan.pupil_samples),
                     static_cast<long long>(plan.pupil_samples), plan.pupil_error, noise,
                     is_cell ? "telescope.mask.edges \"area\" and " : "");
}

Cadence::Cadence(const Scene &scene) : times(static_cast<size_t>(scene.info.frames)), displacements(times.size()) {
    toliman::check(toliman_sim_get_series(scene.sim.get(), 0, times.size(), times.data(), displacements.data()));
}

double span_days(const Scene &scene) {
    const std::vector<double> times = Cadence(scene).times;
    const JsonTree tree = read_scene_json(scene.path);
    const bool has_list = item_of(item_of(tree.get(), "cadence"), "times_days") != nullptr;
    const auto frames = static_cast<double>(times.size());
    const auto [first, last] = std::minmax_element(times.begin(), times.end());
    const double length = *last - *first;
    return has_list || frames < 2 ? length : length * frames / (frames - 1);
}

void check_cadence(const Scene &scene, const std::string &command) {
    constexpr int64_t fewest = 5, most = 400000;
    const int64_t frames = scene.info.frames;
    if (frames < fewest || frames > most)
        throw Failure(kExitUsage, scene.path + ": cadence.frames = " + std::to_string(frames) + ": must be in [" +
                                      std::to_string(fewest) + ", " + std::to_string(most) + "] for " + command);
}

FrameRange::FrameRange(const std::string &text, int64_t frames) {
    const size_t colon = text.find(':');
    first = bound_of(text.substr(0, colon), 0, text);
    end = colon == std::string::npos ? (text.empty() ? frames : first + 1)
                                     : bound_of(text.substr(colon + 1), frames, text);
    if (first < 0 || end <= first || end > frames)
        throw Failure(kExitUsage,
                      "--frames " + text + ": must be FIRST:END with FIRST < END, within 0:" + std::to_string(frames));
}

} // namespace cli
