// Nuisance functions at the samples, orthonormalised: for fits to the samples and for residuals.
#pragma once
#include <vector>

#include "period/peak.hpp"

namespace toliman::period {

// A column has one element per sample, then one per function in use that has a prior: a prior is an observation of the
// coefficient.
class SampleBasis {
  public:
    using Real = long double;
    using Column = std::vector<Real>;

    // weights [samples.count], 1/sigma^2 in any unit; `unit` is the weight of sigma = 1. Uses the functions that the
    // sums of the stream determine.
    SampleBasis(const Stream &stream, const Samples &samples, const Column &weights, Real unit);

    size_t rows() const noexcept { return weights_.size(); }
    size_t used() const noexcept { return functions_.size(); }
    Real weight(size_t row) const noexcept { return weights_[row]; }
    // The values y - mean, and what the priors observe.
    Column values(const Samples &samples, Real mean) const;
    // Removes from x what the functions describe.
    void project(Column &x) const noexcept;
    // Coefficient of the mean in the least-squares fit of the functions to x.
    Real mean_coefficient(const Column &x) const noexcept;

  private:
    void orthonormalise();
    Real dot(const Column &a, const Column &b) const noexcept;

    size_t samples_;
    double value_offset_;
    Column weights_;
    Real mean_prior_ = 0;            // element of the mean function in the row of its prior
    size_t mean_row_ = 0;            // this row
    std::vector<Column> functions_;  // orthonormal
    std::vector<Column> triangular_; // function f = sum over j <= f of triangular_[f][j] functions_[j]
};

// Residuals of the nuisance functions alone, of the samples that were pushed.
std::vector<double> nuisance_residuals(const Stream &stream, const Samples &samples);

} // namespace toliman::period
