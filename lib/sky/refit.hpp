// Orbital elements that agree with their errors and with a series of measured separations.
#pragma once
#include "base/goodness.hpp"
#include "sky/reduction.hpp"

namespace toliman::sky {

struct Measurement {
    Exposure exposure;
    double separation_arcsec, sigma_arcsec;
};

struct Refit {
    System system; // with new elements and errors
    double covariance[kElements][kElements];
    double scale = 0, scale_sigma = 0; // relative error of the plate scale
    Goodness goodness;                 // of the measurements, without the jitter
    double jitter_arcsec = 0;          // white noise added to the sigmas; 0 unless the fit without it is poor
    double next_jitter_arcsec = 0;     // with which the residuals have a chi-square of 1
    size_t outliers = 0;               // measurements that do not belong to the others
    double rms_arcsec = 0;             // of what is left
    int iterations = 0;
};

// Elements without a standard deviation stay as they are. scale_sigma: relative standard deviation of the plate scale,
// 0 = exact. Status::argument if there are no measurements, if no element has a standard deviation, and for exposures
// for which why_unknown() has a reason; otherwise as Predictor::mean. Errors of a measurement have its number.
Refit refit(const Predictor &reference, const std::vector<Measurement> &measurements, double scale_sigma);

} // namespace toliman::sky
