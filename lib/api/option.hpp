// Numbers of options structs for which 0 is the default, and truth values.
#pragma once
#include <cstdint>

#include "base/error.hpp"

namespace toliman::api {

// Returns `value`, or `preset` for 0. Status::argument outside [least, most].
template <class T> T in_range(const char *name, T value, T least, T most, T preset) {
    if (value == 0)
        return preset;
    if (!(value >= least && value <= most))
        fail(Status::argument, "{options->%s} = %.7g: must be in [%.7g, %.7g], or 0 for %.7g", name,
             static_cast<double>(value), static_cast<double>(least), static_cast<double>(most),
             static_cast<double>(preset));
    return value;
}

// Status::argument unless `value` is 0 or 1.
inline void check_truth(const char *name, int32_t value) {
    if (value != 0 && value != 1)
        fail(Status::argument, "{%s} = %d: must be 0 or 1", name, value);
}

} // namespace toliman::api
