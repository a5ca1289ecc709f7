// Power from sums, defined for every input.
#pragma once
#include "period/stream.hpp"

namespace toliman::period {

// Weighted means about the mean (or as they are, where the mean is fixed): of cosine and sine, and of y with each.
template <class Real> struct Moments {
    Real cc, cs, ss, yc, ys;
    Real determinant; // cc ss - cs^2, formed before rounding
};

// Least squares y = cosine c + sine s by the moments; directions with eigenvalues up to `noise` are left out.
struct Solved {
    long double cosine, sine, explained;
    int rank;
};
template <class Real> Solved solve(const Moments<Real> &moments, long double noise) noexcept;

// The share of `spread` that a solution explains, in [0, 1]; 1 where there are as many free parameters as samples.
double explained_share(const Solved &solved, long double spread, bool fixed_mean, int64_t samples) noexcept;

// Cosine and sine coincide where one eigenvalue is below this part of both together: in long double, and in wide sums.
constexpr long double kCoincident = 1e-17L, kCoincidentDoubleLimb = 1e-25L;
// A power whose error bound exceeds this is inaccurate.
constexpr long double kInaccurate = 1e-3L;

// Least squares at one frequency, from the sums: y = offset + cosine cos 2 pi f (t - time offset) + sine sin 2 pi f
// (...). Standard errors are scaled by the residual; +infinity where the samples cannot tell.
struct Model {
    double amplitude, amplitude_error, phase, phase_error, offset, offset_error, power;
    int rank; // of cosine and sine
    bool inaccurate;
};

// What one query needs of the totals, computed once.
class PowerQuery {
  public:
    explicit PowerQuery(const Stream &stream) noexcept;
    // The same with another limit below which cosine and sine coincide.
    PowerQuery(const Stream &stream, long double coincident) noexcept;
    // Power at frequency k of the grid, in [0, 1], never NaN.
    double at(int64_t k) const noexcept;
    // The same of frequencies first, first + 1, ...; what double carries to 1e-13 goes by vectors.
    void range(int64_t first, size_t count, double *power) const noexcept;
    // Fails with Status::state where the power of frequency k is 1 by sums that no samples have: see power.cpp.
    void check_power(int64_t k, double power) const;
    // The same of frequencies first, first + 1, ...
    void check_powers(int64_t first, size_t count) const;
    // At frequency k; meaningful() must hold.
    Model model(int64_t k) const noexcept;
    // Half of the weighted sum of squares about the mean, in units of the caller's sigmas: what `psd` multiplies.
    double half_chi_square() const noexcept;
    // Free parameters of cosine and sine at frequency k: 2, or fewer where they coincide.
    int rank(int64_t k) const noexcept { return solved(k).rank; }
    // Whether the error bound of the power at frequency k, as include/toliman/period.h has it, exceeds kInaccurate;
    // never at frequency 0.
    bool inaccurate(int64_t k) const noexcept;
    // Samples enough and not all equal: a peak means something.
    bool meaningful() const noexcept;
    // Fails if the values scatter too little for the units that value_bound and the sigmas gave the sums.
    void check() const;
    bool resolved() const noexcept;
    // Whether at a frequency above 0 narrow sums may carry the power to less than 1e-9.
    bool needs_double_limb() const noexcept;
    // Whether at a frequency above 0 the power is inaccurate. Multiples of `nyquist` do not count: there the samples of
    // an even series have one phase, and the power of what is left is right.
    bool any_inaccurate(double nyquist) const noexcept;

  private:
    template <class Real> Moments<Real> moments(int64_t k) const noexcept;
    // use(moments at frequency k), with as many digits as they need.
    template <class Use> auto with_moments(int64_t k, Use use) const noexcept;
    template <class Real> Model model(int64_t k, const Moments<Real> &m) const noexcept;
    template <class Real> Solved solved(const Moments<Real> &m) const noexcept;
    Solved solved(int64_t k) const noexcept;
    template <class Real> bool worse(const Moments<Real> &m, long double tolerance) const noexcept;
    template <class Counts> bool any_worse(long double tolerance, Counts counts) const noexcept;
    double frequency(int64_t k) const noexcept {
        return stream_.grid().f0 + stream_.grid().df * static_cast<double>(k);
    }
    template <class Real> bool possible(const Moments<Real> &m) const noexcept;
    bool vectors() const noexcept;
    void by_vectors(int64_t first, size_t count, double *power) const noexcept;
    long double least_scatter() const noexcept;

    const Stream &stream_;
    Quad part_, mean_; // 1/W, Wy/W
    long double spread_;
    long double share_; // samples over W
    long double noise_; // error of a sum over W: an eigenvalue below it is nothing
    long double error_; // bound of the power's error times the smaller eigenvalue
    long double coincident_;
};

} // namespace toliman::period
