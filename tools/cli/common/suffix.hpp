// Tests the suffix of a file name.
#pragma once
#include <string>

namespace cli {

inline bool ends_with(const std::string &path, const std::string &suffix) {
    return path.size() >= suffix.size() && path.compare(path.size() - suffix.size(), suffix.size(), suffix) == 0;
}

} // namespace cli
