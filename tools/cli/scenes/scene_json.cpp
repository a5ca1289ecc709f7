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

void merge(cJSON *object, const cJSON *patch) {
    for (const cJSON *item = patch->child; item != nullptr; item = item->next) {
        cJSON *found = item_of(object, item->string);
        if (!cJSON_IsObject(item) || !cJSON_IsObject(found))
            cJSON_DeleteItemFromObjectCaseSensitive(object, item->string);
        if (cJSON_IsObject(item))
            merge(cJSON_IsObject(found) ? found : cJSON_AddObjectToObject(object, item->string), item);
        else if (!cJSON_IsNull(item))
            cJSON_AddItemToObject(object, item->string, copy_of(item).release());
    }
}

void merge(cJSON *object, const std::string &patch) {
    merge(object, JsonTree(cJSON_Parse(patch.c_str())).get());
}

} // namespace cli
