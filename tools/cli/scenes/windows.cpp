#include "scenes/windows.hpp"

#include <filesystem>

#include "common/content.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

WindowScene window_of(const std::string &path, const cJSON *item, const std::string &where) {
    const cJSON *const start = item_of(item, "first_days"), *const scene = item_of(item, "scene");
    if (!cJSON_IsNumber(start) || !std::isfinite(start->valuedouble))
        malformed(path, where + ".first_days: must be a finite number");
    if (!cJSON_IsString(scene) || scene->valuestring[0] == '\0')
        malformed(path, where + ".scene: must be the name of a scene file");
    return {start->valuedouble, (std::filesystem::path(path).parent_path() / scene->valuestring).string()};
}

} // namespace

bool is_window_list(const std::string &path) {
    const Identity file = identify(path);
    return file.content == Content::result && file.name == "JSON of schema " + std::string(kWindowsSchema);
}

std::vector<WindowScene> windows_of(const std::string &path) {
    if (!is_window_list(path))
        return {{0, path}};
    const std::string text = whole_text(path);
    const JsonTree tree(cJSON_ParseWithLength(text.data(), text.size()));
    const cJSON *const list = tree ? item_of(tree.get(), "windows") : nullptr;
    if (!cJSON_IsArray(list) || list->child == nullptr)
        malformed(path, tree ? "windows: must be a list of at least one window" : "is not JSON");
    std::vector<WindowScene> windows;
    for (const cJSON *item = list->child; item != nullptr; item = item->next)
        windows.push_back(window_of(path, item, "windows[" + std::to_string(windows.size()) + "]"));
    return windows;
}

std::string window_list(const std::vector<WindowScene> &windows) {
    return Json("schema", kWindowsSchema, "windows",
                array_of(windows,
                         [](const WindowScene &window) {
                             return Json("first_days", Exact{window.first_days}, "scene", window.scene);
                         }))
        .text();
}

} // namespace cli
