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
// Applies a merge patch (RFC 7386): objects are merged, null removes an item, other values replace it.
void merge(cJSON *object, const cJSON *patch);
void merge(cJSON *object, const std::string &patch);

} // namespace cli
