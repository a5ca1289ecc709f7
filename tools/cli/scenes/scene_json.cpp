#include "scenes/scene_json.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/failure.hpp"

namespace cli {

namespace {

[[noreturn]] void lost(const std::string &path) {
    malformed(path, "cannot be read again");
}

} // namespace

std::string scene_text(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file)
        lost(path);
    return text;
}

JsonTree read_scene_json(const std::string &path) {
    const std::string text = scene_text(path);
    JsonTree tree(cJSON_ParseWithLength(text.data(), text.size()));
    if (!tree)
        lost(path);
    return tree;
}

JsonTree copy_of(const cJSON *item) {
    return JsonTree(cJSON_Duplicate(item, 1));
}

std::string folder_of(const std::string &path) {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    return folder.empty() ? "." : folder;
}

cJSON *item_of(const cJSON *object, const char *name) {
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

cJSON *object_of(cJSON *object, const char *name) {
    cJSON *found = item_of(object, name);
    return found != nullptr ? found : cJSON_AddObjectToObject(object, name);
}

void put(cJSON *object, const char *name, JsonTree value) {
    cJSON_DeleteItemFromObjectCaseSensitive(object, name);
    cJSON_AddItemToObject(object, name, value.release());
}

void put(cJSON *object, const char *name, double value) {
    put(object, name, JsonTree(cJSON_CreateNumber(value)));
}

} // namespace cli
