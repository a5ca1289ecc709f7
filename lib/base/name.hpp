// Names of sessions and regions, which come from input files and become parts of file names.
#pragma once
#include <cstddef>
#include <string_view>

namespace toliman {

constexpr size_t kLongestName = 64;
constexpr const char *kNameRule = "must be 1 to 64 of A-Z a-z 0-9 . _ - and not begin with a dot";

// Whether text is [A-Za-z0-9._-]{1,64} without a leading dot, so that it cannot form a path to another folder.
constexpr bool is_name(std::string_view text) noexcept {
    if (text.empty() || text.size() > kLongestName || text[0] == '.')
        return false;
    for (const char c : text)
        if (!((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
              c == '-'))
            return false;
    return true;
}

} // namespace toliman
