// Converts the constants of a public enumeration to an internal enum and back. No two public enumerations share a
// value, so that a constant of another enumeration is rejected.
#pragma once
#include <cstdint>

#include "base/error.hpp"

namespace toliman::api {

// The constants first ... last of a public enumeration, in the order of Enum, which counts from 0.
template <class Enum> struct Choice {
    int32_t first, last;
    const char *constants; // "TOLIMAN_CAE_LAYOUT_..."

    bool contains(int32_t value) const noexcept { return value >= first && value <= last; }

    // Status::argument, naming the argument, for any other value.
    Enum to_enum(int32_t value, const char *name) const {
        if (!contains(value))
            fail(Status::argument, "{%s} = %d: must be one of %s, %d to %d", name, value, constants, first, last);
        return static_cast<Enum>(value - first);
    }

    // The same for a member of accepted options, which is one of the constants.
    Enum to_enum(int32_t value) const noexcept { return static_cast<Enum>(value - first); }

    // The same for a number whose default is 0.
    Enum to_enum_or(int32_t value, Enum preset, const char *name) const {
        return value == 0 ? preset : to_enum(value, name);
    }

    int32_t to_constant(Enum value) const noexcept { return first + static_cast<int32_t>(value); }
};

} // namespace toliman::api
