// Least-squares power, model and error bound at each frequency from the sums of a Stream; defined for every input.
#pragma once
#include <optional>

#include "period/stream/projection.hpp"

namespace toliman::period {

// Returns the fraction of `spread` that a solution explains, in [0, 1]; 1 if there are as many free parameters as
// samples. free: those of the model without the sinusoid.
double explained_share(const Solved &solved, long double spread, int64_t free, int64_t samples) noexcept;

// Cosine and sine count as coincident where the smaller eigenvalue is below this fraction of the trace: for long double
// and single-limb accumulators, and for double-limb accumulators.
constexpr long double kCoincident = 1e-17L, kCoincidentDoubleLimb = 1e-25L;
// A power with a larger error bound is flagged as inaccurate.
constexpr long double kInaccurate = 1e-3L;

// Least-squares model at one frequency: y = offset + amplitude sin(2 pi f (t - time_offset) + phase). Standard errors
// are scaled by the residual; +infinity if the samples do not determine the parameter.
struct Model {
    double amplitude, amplitude_error, phase, phase_error, offset, offset_error, power;
    int rank; // of cosine and sine
    bool inaccurate;
};

// Quantities that all frequencies of a query share, computed once from the totals.
class PowerQuery {
  public:
    explicit PowerQuery(const Stream &stream) noexcept;
    // Likewise with another limit for coincident cosine and sine.
    PowerQuery(const Stream &stream, long double coincident) noexcept;
    // Power at frequency k of the grid, in [0, 1], never NaN.
    double at(int64_t k) const noexcept;
    // Powers at frequencies first, first + 1, ...; by a vectorised kernel wherever double keeps the power to 1e-13.
    void range(int64_t first, size_t count, double *power) const noexcept;
    // Fails with Status::state if the power at frequency k is 1 because the sums are inconsistent: see consistent().
    void check_power(int64_t k, double power) const;
    // Likewise for frequencies first, first + 1, ...
    void check_powers(int64_t first, size_t count) const;
    // Model at frequency k; requires meaningful().
    Model model(int64_t k) const noexcept;
    // Coefficients of the nuisance functions fitted with the sinusoid at frequency k; requires meaningful() and
    // functions.
    Coefficients coefficients(int64_t k) const noexcept;
    // Half of the weighted sum of squares about the mean, with weights 1/sigma^2: the factor of the `psd`
    // normalisation.
    double half_chi_square() const noexcept;
    // Number of fitted parameters of cosine and sine at frequency k: 2, or fewer where they coincide.
    int rank(int64_t k) const noexcept { return solved(k).rank; }
    // Returns whether the error bound of the power at frequency k (include/toliman/period.h, Accuracy) exceeds
    // kInaccurate. Always false at frequency 0.
    bool inaccurate(int64_t k) const noexcept;
    // Returns whether there are at least least_samples(), not all equal or described by the nuisance functions alone:
    // fewer determine no peak.
    bool meaningful() const noexcept;
    // Four more than the functions without a prior; at least five.
    int64_t least_samples() const noexcept;
    // Fails unless resolved().
    void check() const;
    // Returns whether the values scatter enough, relative to value_bound and the sigmas, for 12 digits of the power.
    bool resolved() const noexcept;
    // Returns whether single-limb accumulators may have an error of the power above 1e-9 at some frequency above 0.
    bool needs_double_limb() const noexcept;
    // Returns whether the power is inaccurate at some frequency above 0. Multiples of `nyquist` are excluded: there all
    // samples of an evenly spaced series have one phase, and the power of the remaining direction is accurate.
    bool any_inaccurate(double nyquist) const noexcept;

  private:
    template <class Real> Moments<Real> moments(int64_t k) const noexcept;
    // Returns use(moments at frequency k), in long double if that suffices, else in 113 bits.
    template <class Use> auto with_moments(int64_t k, Use use) const noexcept;
    template <class Real> Model model(int64_t k, const Moments<Real> &m) const noexcept;
    template <class Real> Solved solved(const Moments<Real> &m) const noexcept;
    Solved solved(int64_t k) const noexcept;
    template <class Real> long double error_bound(const Moments<Real> &m, long double small) const noexcept;
    template <class Real> bool error_exceeds(const Moments<Real> &m, long double tolerance) const noexcept;
    template <class Counts> bool any_error_exceeds(long double tolerance, Counts counts) const noexcept;
    double frequency(int64_t k) const noexcept {
        return stream_.grid().f0 + stream_.grid().df * static_cast<double>(k);
    }
    template <class Real> bool consistent(const Moments<Real> &m) const noexcept;
    bool vectorisable() const noexcept;
    // Returns the number of powers that need more precision than the vectorised kernel has.
    size_t range_by_vectors(int64_t first, size_t count, double *power) const noexcept;
    long double min_spread() const noexcept;
    // Residual per degree of freedom of a solution.
    long double scale(const Solved &best) const noexcept;
    void project() noexcept;

    const Stream &stream_;
    Quad weight_, inverse_weight_, mean_; // W, 1/W, Wy/W
    long double spread_;
    long double samples_over_weight_; // count/W
    long double noise_;               // error of a sum divided by W: smaller eigenvalues are insignificant
    long double error_;               // error bound of the power times the smaller eigenvalue
    long double coincident_;
    int64_t free_; // parameters of the model without the sinusoid, except those with a prior
    std::optional<Projection> projection_;
};

} // namespace toliman::period
