// The scenes of a calibration with several windows of time: a file of schema toliman-calibration/1.
#pragma once
#include <string>
#include <vector>

namespace cli {

inline constexpr char kWindowsSchema[] = "toliman-calibration/1";

struct WindowScene {
    double first_days; // start of the window
    std::string scene; // path
};

// Whether the file is such a list.
bool is_window_list(const std::string &path);
// The windows of a list; for any other file, one window with it as the scene.
std::vector<WindowScene> windows_of(const std::string &path);
// The text of a list; names of scenes are relative to its folder.
std::string window_list(const std::vector<WindowScene> &windows);

} // namespace cli
