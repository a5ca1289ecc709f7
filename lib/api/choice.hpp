// Public enumerations: constants of values that no other enumeration has, in the order of the library's own.
#pragma once
#include <cstdint>

#include "base/error.hpp"

namespace toliman::api {

// The constants first ... last of a public enumeration, whose order is that of Enum, which counts from 0.
template <class Enum> struct Choice {
    int32_t first, last;
    const char *constants; // "TOLIMAN_CAE_LAYOUT_..."

    bool holds(int32_t value) const noexcept { return value >= first && value <= last; }

    Enum take(int32_t value, const char *name) const {
        if (!holds(value))
            fail(Status::argument, "{%s} = %d: must be one of %s, %d to %d", name, value, constants, first, last);
        return static_cast<Enum>(value - first);
    }

    // Of an option, where 0 stands for the default.
    Enum take_or(int32_t value, Enum preset, const char *name) const { return value == 0 ? preset : take(value, name); }

    int32_t give(Enum value) const noexcept { return first + static_cast<int32_t>(value); }
};

} // namespace toliman::api
