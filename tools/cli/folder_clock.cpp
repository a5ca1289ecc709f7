#include "folder_clock.hpp"

#include <cstdint>
#include <cstring>

#include "failure.hpp"
#include "input.hpp"

namespace cli {

namespace {

template <class T> T number(const unsigned char *bytes) noexcept { // little-endian, as the machine
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

} // namespace

// TLMC of lib/FORMATS.md.
bool clock_changes_time(const std::string &folder) {
    const std::string path = folder + "/checkpoint.tlmc";
    if (!exists(path))
        return false;
    InputFile file(path);
    unsigned char head[40], point[16];
    if (!file.read(head, sizeof head) || std::memcmp(head, "TLMC\1\0\0\0", 8) != 0)
        throw Failure(kExitState, path + ": is no checkpoint of version 1");
    for (auto left = number<uint32_t>(head + 36); left > 0; left--)
        if (!file.read(point, sizeof point) || number<int64_t>(point) != number<int64_t>(point + 8))
            return true;
    return false;
}

} // namespace cli
