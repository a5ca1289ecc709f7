// The two-call protocol of every _save function: with bytes NULL it returns the size, otherwise it copies the bytes.
#pragma once
#include <cstdint>
#include <cstring>
#include <vector>

#include "api/guard.hpp"

namespace toliman::api {

inline void deliver_bytes(const std::vector<uint8_t> &content, void *bytes, size_t capacity, size_t *needed) {
    required(needed, "needed");
    if (bytes != nullptr) {
        if (capacity < content.size())
            fail(Status::capacity, "{capacity} = %zu: must be at least %zu bytes", capacity, content.size());
        std::memcpy(bytes, content.data(), content.size());
    }
    *needed = content.size();
}

} // namespace toliman::api
