// Period search in a series with correlated noise, whose correlation is fitted.
#pragma once
#include "base/progress.hpp"
#include "period/noise/noise_model.hpp"

namespace toliman::period {

struct NoiseGrid {
    double f0, df;
    size_t nf;

    double at(size_t k) const noexcept { return f0 + static_cast<double>(k) * df; }
    double last() const noexcept { return at(nf - 1); }
};

struct NoiseResult {
    double rho, rho_error; // correlation over one median step
    double log10_p_white;  // of the likelihood ratio against white noise, with the strongest sinusoid in the model
    size_t index;          // highest power of the grid
    double power, log10_residual, log10_fap; // of that grid point
    double frequency;                        // refined by least squares within one step of the grid
    NoiseSolution solution;                  // at that frequency
    int rank;
};

// Computes power [nf] in the metric of the fitted noise, or of white noise if `white`; coefficients and errors of mean
// and functions.
NoiseResult search_noise(NoiseModel &model, const NoiseGrid &grid, bool white, const Progress &progress, double *power,
                         double *coefficients, double *errors);

// log10 of Baluev's false alarm probability for the samples and functions of a model.
double log10_fap(const NoiseModel &model, const NoiseGrid &grid, double log10_residual) noexcept;

} // namespace toliman::period
