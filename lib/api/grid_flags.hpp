// Converts the TOLIMAN_PERIOD_... flags of a grid to its members and back.
#pragma once
#include <toliman/period.h>

#include "base/error.hpp"
#include "period/stream/stream.hpp"

namespace toliman::api {

inline void set_flags(period::Grid &grid, uint32_t flags) {
    grid.fixed_mean = (flags & TOLIMAN_PERIOD_FIXED_MEAN) != 0;
    grid.double_limb_sums = (flags & TOLIMAN_PERIOD_DOUBLE_LIMB) != 0;
}

inline uint32_t flags_of(const period::Grid &grid) noexcept {
    return (grid.fixed_mean ? TOLIMAN_PERIOD_FIXED_MEAN : 0u) | (grid.double_limb() ? TOLIMAN_PERIOD_DOUBLE_LIMB : 0u);
}

} // namespace toliman::api
