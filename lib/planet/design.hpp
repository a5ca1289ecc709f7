// The nuisance functions at the measurements, whitened and orthonormal: what they leave of values and signals.
#pragma once
#include <cstddef>
#include <vector>

#include "base/buffer.hpp"
#include "planet/series.hpp"

namespace toliman::planet {

class Design {
  public:
    // values [rows]: data without the signals of known planets. A function that those before it describe is left out.
    Design(const Series &series, const std::vector<const Function *> &functions, const Buffer<double> &values,
           double jitter);

    size_t functions() const noexcept { return count_; }
    // Functions whose coefficient has no prior.
    size_t free() const noexcept { return free_; }
    // Index of the first function that was left out, or that of no function.
    size_t dependent() const noexcept { return dependent_; }
    const Buffer<double> &weights() const noexcept { return weights_; }
    // [functions() + 1][rows]: the orthonormal functions, then the whitened values without what the functions describe.
    const double *table() const noexcept { return table_.data(); }
    const double *residuals() const noexcept { return &table_[count_ * rows_]; }
    // Sum of the squares of the residuals, with those of the priors.
    double square() const noexcept { return square_; }
    // ln of the evidence without a planet, but for terms that do not depend on the jitter.
    double log_null() const noexcept { return log_null_; }

    // Of each measurement, the part of its variance that the fit takes away: the sum of squares of its row of
    // the orthonormal functions.
    std::vector<double> leverages() const;

    // Coefficients of all functions in the least-squares fit of the values; 0 for those left out.
    std::vector<double> coefficients() const;
    // [all functions][all functions], of the coefficients; 0 for those left out.
    std::vector<double> covariance() const;

    // The measurements' rows of what the functions leave of x [rows], whitened. Its product with another vector is that
    // of what is left of both; its square is not, as the rows of the priors are missing.
    void project(double *x) const;

  private:
    size_t all_, rows_, count_ = 0, free_ = 0, dependent_;
    Buffer<double> weights_, table_;
    std::vector<size_t> index_;                      // of the functions in use
    std::vector<std::vector<long double>> triangle_; // R: function j = sum over i <= j of triangle_[j][i] q_i
    std::vector<long double> along_;                 // of the values
    double square_ = 0, log_null_ = 0;
};

// Jitter of a design without a further one: 0, or 1 for equal weights without sigmas.
inline double unit_jitter(const Series &series) noexcept {
    return series.median_sigma > 0 ? 0 : 1;
}

} // namespace toliman::planet
