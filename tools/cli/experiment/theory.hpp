// Results expected in theory of estimates that scatter by the Cramer-Rao bound, and a test for uniformity.
#pragma once
#include <vector>

#include "scenes/scene.hpp"
#include "series/periodogram.hpp"

namespace cli {

// For one cadence and the shape of one signal.
class Theory {
  public:
    // shape: the signal of amplitude 1 at the times.
    Theory(const std::vector<double> &times, const std::vector<double> &shape, const FrequencyGrid &grid);

    // log10 of Baluev's FAP if the residual over the total sum of squares is sigma^2 / (sigma^2 + var(signal)).
    double log10_fap(double amplitude_px, double sigma_px) const;
    // The amplitude at which it is kFound, -3.
    double threshold_px(double sigma_px) const;
    // The amplitude above which the signal is the first principal component of whitened frames: its variance over
    // sigma^2 must exceed sqrt(pixels/frames) (Baik, Ben Arous, Peche 2005, Ann. Probab. 33, 1643). For a sinusoid
    // A = sigma sqrt(2 sqrt(pixels/frames)).
    double pca_threshold_px(double sigma_px, double pixels) const;

  private:
    toliman::periodogram periodogram_;
    double frames_, variance_; // of the shape
};

constexpr double kFound = -3; // log10 FAP below which a period counts as found

double median(std::vector<double> values); // NaN if empty; for an even number the mean of the middle two

// p-value of the Kolmogorov-Smirnov test that the values are drawn from the uniform distribution on [0, 1], with the
// correction of Stephens (1970) for their number. NaN if empty.
double uniformity(std::vector<double> values);

} // namespace cli
