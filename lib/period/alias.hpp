// Aliases: frequencies at which the sampling repeats a peak.
#pragma once
#include <cstddef>
#include <cstdint>

#include "period/stream/power.hpp"

namespace toliman::period {

enum class Cause : int32_t { sampling, solar_day, sidereal_day, year };

struct Alias {
    double frequency;
    double power; // highest within 1/T of it; NaN outside the grid
    Cause cause;
    double interval; // 1/g of the window function's peak
    int parts;       // of the day: the interval is day/parts; otherwise 1
    double window;   // fraction of the peak's power that the sampling repeats there, in [0, 1]
    bool equal;      // the samples do not tell the two frequencies apart
    bool slow;       // its frequency is below the grid and below 2.5/T
};

constexpr size_t kMaxAliases = 16;

// Window function (C1^2 + S1^2)/W^2 at the frequency `gap`: the fraction of a sinusoid's power that the sampling
// repeats at this distance. 1 within the width of a peak; 0 where it is not known, outside the grid and its double.
double window(const Stream &stream, double gap) noexcept;

// Returns `highest`, the grid point of the highest peak, or that of the longest period of which it may be an alias: the
// window function is above kRepeats, and the longer period is as probable or more.
int64_t prefer_longest(const PowerQuery &query, const Stream &stream, int64_t highest) noexcept;
constexpr double kRepeats = 0.5;

// Finds the aliases of a peak at `frequency`, those of the highest window function first. The highest
// peak of the grid is listed if it is an alias. Returns their number, at most kMaxAliases.
size_t find_aliases(const Stream &stream, double frequency, Alias *aliases);

} // namespace toliman::period
