// The spread of a sum of frames, from and to the caller.
#pragma once
#include <toliman/spread.h>

#include "frame/spread.hpp"

namespace toliman::api {

// NULL: one frame. Status::argument, naming the member after `name`, for a spread that no places have.
Spread spread_of(const toliman_spread *given, const char *name);
toliman_spread public_spread(const Spread &spread) noexcept;

} // namespace toliman::api
