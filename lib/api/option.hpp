// Rules of the members of an options struct, as the comments of the headers give them: tools/gen/options.py makes the
// tables of option_rules.hpp from these.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "base/error.hpp"

namespace toliman::api {

enum class OptionKind : uint8_t { int32, uint32, int64, uint64, real };

template <class T>
constexpr OptionKind kind_of = std::is_same_v<T, double> ? OptionKind::real
                               : sizeof(T) == 4      ? (std::is_signed_v<T> ? OptionKind::int32 : OptionKind::uint32)
                               : std::is_signed_v<T> ? OptionKind::int64
                                                     : OptionKind::uint64;

// Marks of a rule.
constexpr unsigned kOpenLeast = 1, kOpenMost = 2, kZero = 4, kFlags = 8;
constexpr double kLargest = std::numeric_limits<double>::max();

struct OptionRule {
    const char *member; // "prior.period_min"
    size_t offset;
    OptionKind kind;
    uint32_t count;      // elements of an array
    unsigned marks;      // kZero: 0 is allowed, the default; kFlags: bits of `most`
    double least, most;  // limits, which kOpenLeast and kOpenMost exclude
    double preset;       // replaces 0, unless it is 0
    const char *allowed; // for messages: "in [0.05, 4] px, or 0 for 0.5"
};

// Table kRules of an options struct; empty for any other.
template <class T> struct OptionRules {
    static constexpr OptionRule kRules[1] = {};
};

// Checks the members of a struct, and replaces 0 by its preset. Status::argument, naming the member.
void complete(void *options, const char *name, const OptionRule *rules, size_t count);

} // namespace toliman::api
