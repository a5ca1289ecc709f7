// Progress and log callbacks of an options struct, for domain code.
#pragma once
#include <cstdint>

#include "base/error.hpp"

namespace toliman {

struct Progress {
    int32_t (*call)(const char *stage, double fraction, void *user_data) = nullptr;
    void *user_data = nullptr;

    // Calls the callback, on the caller's thread only and with no lock held. Returns whether it asks to stop.
    bool asks_to_stop(const char *stage, double fraction) const {
        return call != nullptr && in_callback("progress", [&] { return call(stage, fraction, user_data); }) != 0;
    }
    // The same; Status::cancelled if it asks to stop.
    void report(const char *stage, double fraction) const {
        if (asks_to_stop(stage, fraction))
            fail(Status::cancelled, "%s: cancelled by the progress callback", stage);
    }
};

struct Log {
    void (*call)(int32_t level, const char *text, void *user_data) = nullptr;
    void *user_data = nullptr;

    void warn(const char *format, ...) const __attribute__((format(printf, 2, 3)));
};

} // namespace toliman
