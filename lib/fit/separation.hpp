// The separation among the parameters of a frame.
#pragma once
#include "fit/fit.hpp"

namespace toliman::fit {

// How the model's parameters change per px of separation if all others are fitted to the frame again: with covariance C
// and the gradient a of the separation by the parameters, C a/(a C a). The image of this change is the derivative by
// the separation with those by all others projected out: the matched filter.
struct SeparationAxis {
    double change[kMostParameters];
    double variance_px2; // a C a, of the separation: the Cramer-Rao bound
    // Share of B's displacement in that of both stars that a shift of the filter should follow: with the variance of
    // the place of each star, B/(A + B). The filter's part of a star has the norm of the inverse standard deviation of
    // its place, so that this shift loses least.
    double share_b;
};

SeparationAxis separation_axis(const State &state, size_t parameters) noexcept;
double separation_of(const double *values) noexcept;

} // namespace toliman::fit
