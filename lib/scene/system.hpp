// System files (schema toliman-system/1): a binary with its orbit, place, motion and masses.
#pragma once
#include <string>

#include "sky/system.hpp"

namespace toliman {

// Status::not_found; Status::scene with file and key.
sky::System read_system(const std::string &path);
sky::System read_system(const std::string &json, const std::string &source);
// "alpha-cen", the JSON text of a system, or the path of a file. Status::argument for "".
sky::System named_system(const std::string &name);
// The text of a system file.
std::string system_json(const sky::System &system);

} // namespace toliman
