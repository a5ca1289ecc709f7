// The posterior at a node of the lattice: an orbit with coefficients and amplitudes marginalised.
#pragma once
#include <cstddef>
#include <vector>

#include "planet/design.hpp"
#include "planet/signal.hpp"

namespace toliman::planet {

// Normal equations of the amplitudes, about the nuisance functions.
struct Moments {
    double right[kMostAmplitudes];
    double matrix[kMostAmplitudes][kMostAmplitudes]; // lower triangle
    size_t size;
};

// Computes moments; keeps the shapes of the last orbit.
class ShapeWork {
  public:
    explicit ShapeWork(const Series &series) : shapes_(series.amplitudes() * series.rows), weighted_(shapes_.size()) {}
    Moments moments(const Series &series, const Design &design, const Orbit &orbit);

  private:
    Orbit orbit_ = {0, 0, 0}; // a planet has a frequency
    Buffer<double> shapes_, weighted_;
    std::vector<double> products_;
};

// Amplitudes with a Gaussian prior of standard deviation `scale`: mean and factor L of the inverse covariance L L^T,
// and ln of the Bayes factor against no signal.
struct AmplitudeFit {
    double mean[kMostAmplitudes];
    double factor[kMostAmplitudes][kMostAmplitudes];
    double log_bayes;
};
AmplitudeFit fit_amplitudes(const Moments &moments, double scale) noexcept;

// ln of the Bayes factor, in the mean over scales of equal weight. each [scales.size()]: those of the scales; may be
// NULL.
double log_bayes(const Moments &moments, const std::vector<double> &scales, double *each) noexcept;

} // namespace toliman::planet
