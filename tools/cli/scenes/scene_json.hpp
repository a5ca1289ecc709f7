// A scene file as a JSON tree that may be changed, for commands that try variants of a scene. The library has read the
// file before: what it must hold is checked.
#pragma once
#include <string>

#include "common/json.hpp"

namespace cli {

JsonTree read_scene_json(const std::string &path);
JsonTree copy_of(const cJSON *item);
// Where relative file names of the scene at `path` start.
std::string folder_of(const std::string &path);

// nullptr where there is none, also of nullptr.
cJSON *item_of(const cJSON *object, const char *name);
// The object under `name`, made empty where there is none.
cJSON *object_of(cJSON *object, const char *name);
void put(cJSON *object, const char *name, JsonTree value);
void put(cJSON *object, const char *name, double value);

} // namespace cli
