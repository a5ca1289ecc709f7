// Normal equations of a sinusoid and their solution.
#pragma once

namespace toliman::period {

// Weighted covariances of cosine and sine, and of y with each; about the weighted mean, or about 0 with a fixed mean,
// or of what remains after the nuisance functions are projected out.
template <class Real> struct Moments {
    Real cc, cs, ss, yc, ys;
    Real determinant; // cc ss - cs^2, computed before rounding to long double
    // With nuisance functions: error of cc, cs, ss; error of yc, ys divided by the standard deviation of y.
    long double noise = 0, value_noise = 0;
};

// Solves the least-squares problem y = cosine c + sine s from its moments. Directions with an eigenvalue of at most
// `noise` are not fitted; rank is the number of those that are.
struct Solved {
    long double cosine, sine, explained;
    int rank;
};
template <class Real> Solved solve(const Moments<Real> &moments, long double noise) noexcept;

} // namespace toliman::period
