// Ranges of the values of a series. Differences and squares of them neither overflow nor underflow in double.
#pragma once
#include <cmath>
#include <cstddef>

namespace toliman::ingest {

constexpr size_t kSeriesFewest = 2, kSeriesMost = 3; // columns
constexpr const char *kSeriesColumns[kSeriesMost] = {"t", "y", "sigma"};

// The range that a value of a column violates; nullptr: none.
inline const char *flaw_of(double value, size_t column) noexcept {
    constexpr double kLargest = 1e98, kLeastSigma = 1e-98;
    if (!std::isfinite(value))
        return "must be a finite number";
    if (column == 2)
        return value >= kLeastSigma && value <= kLargest ? nullptr : "must be in [1e-98, 1e98]";
    return std::fabs(value) > kLargest ? "must be in [-1e98, 1e98]" : nullptr;
}

} // namespace toliman::ingest
