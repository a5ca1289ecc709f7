// Writes a goodness of fit to the members that all results have for it.
#pragma once
#include <toliman/goodness.h>

#include "api/choice.hpp"
#include "frame/bad_pixels.hpp"

namespace toliman::api {

constexpr Choice<GoodnessVerdict> kGoodness = {TOLIMAN_GOODNESS_UNKNOWN, TOLIMAN_GOODNESS_TOO_GOOD,
                                               "TOLIMAN_GOODNESS_..."};

template <class Result> void set_goodness(const Goodness &goodness, Result &out) noexcept {
    out.chi_square = goodness.chi_square;
    out.chi_square_sigma = goodness.sigma;
    out.largest_residual = goodness.largest;
    out.goodness = kGoodness.to_constant(goodness.verdict);
}

// The same of a frame, with the number of its bad pixels.
template <class Result> void set_frame_goodness(const FrameGoodness &goodness, Result &out) noexcept {
    set_goodness(goodness, out);
    out.bad_pixels = static_cast<uint32_t>(goodness.bad_pixels);
}

} // namespace toliman::api
