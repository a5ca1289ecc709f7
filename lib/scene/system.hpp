// System files (schema toliman-system/1): a binary with its orbit, place, motion and masses.
#pragma once
#include <string>

#include "sky/system.hpp"

namespace toliman {

// Status::not_found; Status::scene with file and key.
sky::System read_system(const std::string &path);
sky::System read_system(const std::string &json, const std::string &source);
// The text of a system file.
std::string system_json(const sky::System &system);

} // namespace toliman
