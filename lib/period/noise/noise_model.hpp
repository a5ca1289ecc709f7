// Series with correlated noise: whitening, and least squares of mean, nuisance functions and sinusoid in that metric.
#pragma once
#include "base/buffer.hpp"
#include "period/batch/archive.hpp"

namespace toliman::period {

// Samples with the values of nuisance functions [n][k], all but the mean. precision [k] are those of Gaussian priors of
// mean 0 of their coefficients, 1/sigma^2, 0 for none; functions and precision may be NULL if k is 0, precision always.
struct NoiseSamples {
    BatchSamples samples;
    const double *functions;
    size_t k;
    const double *precision;
};

// Largest correlation over one median step that is fitted.
constexpr double kMaxRho = 0.999;

// Cosine and sine of a frequency at the samples, ordered by time; phases about NoiseModel::reference().
struct NoiseWave {
    double frequency;
    Buffer<double> cosine, sine;
};

// Least squares of mean, nuisance functions and a sinusoid. Squares are in units of the scaled values.
struct NoiseFit {
    int rank;                       // of cosine and sine: directions that the functions leave
    double residual, null_residual; // sum of squares with the sinusoid and without it
    double log_volume;              // log determinant of X^T C^-1 X, without constants
};

// Coefficients of a fit, in the caller's units, with standard errors scaled by the residual; +infinity if the samples
// do not determine them. y = offset + amplitude sin(2 pi f (t - reference) + phase) + functions.
struct NoiseSolution {
    double amplitude, amplitude_error, phase, phase_error, frequency_error;
};

class NoiseModel {
  public:
    // Fails naming the first invalid sample or function. Frequencies up to `last` will be used.
    NoiseModel(const NoiseSamples &given, double last);

    // Whitens mean, functions and values for a correlation `rho` in [0, kMaxRho] over one median step, and
    // orthogonalises them. Everything below refers to it.
    void set_rho(double rho);
    double rho() const noexcept { return rho_; }
    // Fails unless the functions are linearly independent and leave some of the values.
    void check() const;

    // Powers at f0 + k df, k < nf, in [0, 1].
    void powers(double f0, double df, size_t nf, double *power) const;
    NoiseWave wave(double frequency) const;
    NoiseFit fit(const NoiseWave &wave) const;
    // Restricted log likelihood of rho() with a sinusoid, maximised over the coefficients and the scale of the noise.
    double log_likelihood(const NoiseFit &fit) const noexcept;
    // Likelihood without restriction, comparable between models with a sinusoid and without.
    double log_profile(const NoiseFit &fit) const noexcept;
    // values, errors [functions()]: coefficients of mean and functions.
    NoiseSolution solve(const NoiseWave &wave, double *values, double *errors) const;
    // Asymptotic standard error of rho, from the times alone.
    double rho_error() const noexcept;

    size_t samples() const noexcept { return n_; }
    // Mean and nuisance functions: all, and those without a prior.
    size_t functions() const noexcept { return m_; }
    size_t free_functions() const noexcept { return free_; }
    double step() const noexcept { return step_; }
    double reference() const noexcept { return archive_.reference; }
    // Weighted variance of the times.
    double time_variance() const noexcept;

    // Whitened residuals [samples()] about mean and nuisance functions, ordered by time.
    const double *residuals() const noexcept { return column(m_); }
    // Replaces the whitened values, for powers() until the next set_rho(). False if the functions describe all of them.
    bool set_residuals(const double *whitened) noexcept;

  private:
    using Column = Buffer<double>;
    void order();
    void scale_columns(const NoiseSamples &given);
    void whiten(const double *in, double *out) const noexcept;
    void orthogonalise() noexcept;
    void project(double *column, double *along, size_t functions) const noexcept;
    double dot(const double *a, const double *b) const noexcept;
    const double *column(size_t j) const noexcept { return &whitened_[j * rows_]; }
    double *column(size_t j) noexcept { return &whitened_[j * rows_]; }
    // What the functions leave of cosine and sine.
    struct Directions;
    Directions directions(const NoiseWave &wave) const;
    double remove(const double *direction, double *column) const noexcept;
    void back_substitute(double *right) const noexcept;
    class Scan;

    Archive archive_;
    size_t n_, m_, rows_; // samples; functions with the mean; samples and one row per prior
    size_t free_ = 1;
    double step_ = 0, value_unit_ = 1, rho_ = -1, log_determinant_ = 0, null_residual_ = 0;
    bool described_ = false; // functions describe all values
    size_t dependent_ = 0;   // first function that depends on those before it
    Buffer<size_t> order_;
    Column t_high_, t_low_, gap_, weight_; // ordered by time: gaps in steps, and least sigma/sigma
    Column columns_;                       // [m + 1][n]: functions, values
    Column unit_, prior_;                  // [m]: scale of each function, and its row of prior
    Column own_, previous_;                // factors of a sample and of the one before in the whitened one
    Column whitened_;                      // [m + 1][rows]: orthonormal functions; values without them
    Column triangle_, along_;              // [m][m] and [m]: of the functions, and of the values along them
};

} // namespace toliman::period
