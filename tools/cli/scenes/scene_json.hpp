// A scene file as a JSON tree that can be changed, for commands that evaluate variants of a scene. The library has read
// and checked the file before.
#pragma once
#include <string>

#include "common/json.hpp"

namespace cli {

JsonTree read_scene_json(const std::string &path);
// `text` is the content of the file.
JsonTree parse_scene(const std::string &path, const std::string &text);
JsonTree copy_of(const cJSON *item);
// The folder at which relative file names of the scene at `path` start.
std::string folder_of(const std::string &path);

// nullptr if there is no such item or if object is nullptr.
cJSON *item_of(const cJSON *object, const char *name);
// The object under `name`, created empty if there is none.
cJSON *object_of(cJSON *object, const char *name);
void put(cJSON *object, const char *name, JsonTree value);
void put(cJSON *object, const char *name, double value);

} // namespace cli
