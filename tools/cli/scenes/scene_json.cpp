#include "scenes/scene_json.hpp"

#include <filesystem>

#include "common/failure.hpp"
#include "common/input.hpp"

namespace cli {

JsonTree read_scene_json(const std::string &path) {
    return parse_scene(path, whole_text(path));
}

JsonTree parse_scene(const std::string &path, const std::string &text) {
    JsonTree tree(cJSON_ParseWithLength(text.data(), text.size()));
    if (!tree)
        malformed(path, "changed while it was read");
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
