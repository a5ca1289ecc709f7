#include "scenes/scene_defaults.hpp"

#include <filesystem>

#include "scenes/scene_json.hpp"

namespace cli {

namespace {

std::string text_of(const cJSON *item) {
    return cJSON_IsString(item) != 0 ? item->valuestring : "";
}

std::optional<double> number_in(const cJSON *object, const char *name) {
    const cJSON *const item = item_of(object, name);
    return cJSON_IsNumber(item) != 0 ? std::optional(item->valuedouble) : std::nullopt;
}

// Relative names start at the folder of the scene.
std::string file_of(const std::string &scene, const std::string &name) {
    const std::filesystem::path path(name);
    return name.empty() || path.is_absolute() ? name : folder_of(scene) + "/" + name;
}

bool is_file(const std::string &orbit) {
    return std::filesystem::path(orbit).extension() == ".json";
}

void set_observer(const cJSON *observer, SceneDefaults &defaults) {
    const std::string word = text_of(observer);
    defaults.has_observer = cJSON_IsObject(observer) != 0 || (!word.empty() && word != "none");
    defaults.observer_file = file_of(defaults.path, text_of(item_of(observer, "file")));
    defaults.altitude_km = number_in(observer, "altitude_km");
    defaults.node_hours = number_in(observer, "node_hours");
}

} // namespace

SceneDefaults scene_defaults(const std::string &path) {
    const JsonTree tree = read_scene_json(path);
    const cJSON *const binary = item_of(tree.get(), "binary"), *const cadence = item_of(tree.get(), "cadence");
    SceneDefaults defaults;
    defaults.path = path;
    const std::string orbit = text_of(item_of(binary, "orbit"));
    if (cJSON_IsTrue(item_of(binary, "moving")) != 0)
        defaults.system = is_file(orbit) ? file_of(path, orbit) : orbit;
    set_observer(item_of(binary, "observer"), defaults);
    defaults.exposure_s = number_in(cadence, "exposure_s").value_or(0);
    defaults.on_target_file = file_of(path, text_of(item_of(cadence, "on_target")));
    const cJSON *const on_target = item_of(cadence, "on_target_s");
    for (const cJSON *item = on_target != nullptr ? on_target->child : nullptr; item != nullptr; item = item->next)
        defaults.on_target_s.push_back(item->valuedouble);
    return defaults;
}

std::string system_or_that_of(const SceneDefaults &scene, const std::string &given, bool is_wanted, Notes &notes) {
    std::error_code none;
    if (given.empty())
        return is_wanted ? scene.system : "";
    if (!scene.system.empty() && given != scene.system && !std::filesystem::equivalent(given, scene.system, none))
        notes.push_back("--system " + given + ": instead of binary.orbit of " + scene.path + ", " + scene.system);
    return given;
}

} // namespace cli
