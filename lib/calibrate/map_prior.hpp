// The prior of the OPD map, and the preconditioner of its fit: filters in the frequency domain.
#pragma once
#include "backend/fft.hpp"
#include "base/buffer.hpp"

namespace toliman::calibrate {

// One thread at a time. Maps are [n][n].
class MapPrior {
  public:
    // Of `rms_m` in each of n x n cells.
    MapPrior(size_t n, double rms_m);

    // The map of an unknown of which each element is standard normal: C^(1/2) times it, C the covariance.
    Buffer<double> opd_of(const Buffer<double> &unknown);
    // Its inverse.
    Buffer<double> unknown_of(const Buffer<double> &opd_m);
    // (excess + h C)^-1 times `unknown`, with one h for its part that is even about the centre of the map, one for the
    // odd.
    Buffer<double> preconditioned(const Buffer<double> &unknown, const double (&curvature)[2], double excess);

  private:
    template <class Gain> Buffer<double> filtered(const Buffer<double> &map, const Gain &gain);

    size_t n_;
    Buffer<double> power_; // of each frequency, m^2: the eigenvalues of C
    fft::Square fft_;
};

// The parts of a map that are even and odd about its centre.
struct Parities {
    Buffer<double> even, odd;
};
Parities parities_of(const Buffer<double> &map);

} // namespace toliman::calibrate
