// The clock that a folder of `toliman track` was made with.
#pragma once
#include <string>

namespace cli {

// Whether it changes the camera's time; false also where the checkpoint, which holds it, is not there.
bool clock_changes_time(const std::string &folder);

} // namespace cli
