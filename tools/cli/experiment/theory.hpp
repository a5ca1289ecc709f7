// What may be expected: of estimates that scatter by the Cramer-Rao bound, and of numbers drawn from a distribution.
#pragma once
#include <vector>

#include "scenes/scene.hpp"
#include "series/periodogram.hpp"

namespace cli {

// Of one cadence and the shape of one signal.
class Theory {
  public:
    // `shape` is the signal of amplitude 1 at the times.
    Theory(const std::vector<double> &times, const std::vector<double> &shape, const FrequencyGrid &grid);

    // log10 of Baluev's FAP where the residual over the total sum of squares is sigma^2 / (sigma^2 + var(signal)).
    double log10_fap(double amplitude_px, double sigma_px) const;
    // The amplitude at which it is -3.
    double threshold_px(double sigma_px) const;
    // The amplitude above which the signal is the first principal component of whitened frames: its variance over
    // sigma^2 must exceed sqrt(pixels/frames) (Baik, Ben Arous, Peche 2005, Ann. Probab. 33, 1643). For a sinusoid
    // A = sigma sqrt(2 sqrt(pixels/frames)).
    double pca_threshold_px(double sigma_px, double pixels) const;

  private:
    toliman::periodogram periodogram_;
    double frames_, variance_; // of the shape
};

constexpr double kFound = -3; // log10 FAP below which a period counts

double median(std::vector<double> values); // NaN of none; the mean of the middle two

// Chance that n numbers drawn evenly from 0 to 1 lie as unevenly as these: Kolmogorov-Smirnov, with Stephens' (1970)
// correction of the number. NaN of none.
double uniformity(std::vector<double> values);

} // namespace cli
