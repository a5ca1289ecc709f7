// Projects the nuisance functions of a Stream out of cosine, sine and values, from the sums.
#pragma once
#include "kernels/power_rows.hpp"
#include "period/stream/moments.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

// Coefficients of all functions with their standard errors, in the caller's units; the mean includes value_offset. Of a
// function that is not in use: 0 and +infinity.
struct Coefficients {
    double value[kMaxFunctions], error[kMaxFunctions];
};

class Projection {
  public:
    explicit Projection(const Stream &stream) noexcept;

    // Functions in use. Those that the samples do not determine, beginning with the highest orders of the trend, are
    // left out until the samples do.
    size_t used() const noexcept { return used_; }
    size_t index(size_t i) const noexcept { return index_[i]; }
    // Functions in use whose coefficient has no prior.
    size_t free() const noexcept { return free_; }
    // 1/sigma^2 of the prior of function f, in units of the sums.
    Quad precision(size_t f) const noexcept;

    // Residual sum of squares of the nuisance model alone, with its priors, divided by W; in units of value_bound^2. 0
    // if the functions describe all values.
    long double spread() const noexcept { return spread_; }

    // Returns use(moments at frequency k, about the functions), in long double if that suffices, else in 113 bits.
    template <class Use> auto with_moments(int64_t k, Use use) const noexcept {
        bool suffices = false;
        if (!needs_quad_)
            if (const auto m = moments<long double>(k, suffices); suffices)
                return use(m);
        return use(moments<Quad>(k, suffices));
    }

    // Powers at frequencies first, first + 1, ... in double, kNeedsMore (kernels/power.hpp) where that does not
    // suffice. Returns their number. Requires vectorisable().
    size_t range(int64_t first, size_t count, double *power) const noexcept;
    bool vectorisable() const noexcept { return vectorisable_; }

    // Coefficients fitted with a sinusoid at frequency k. scale: residual over degrees of freedom.
    void coefficients(int64_t k, const Solved &sinusoid, long double scale, Coefficients &out) const noexcept;

  private:
    template <class Real> using Vector = std::array<Real, kMaxFunctions>;
    template <class Real> struct Factor {
        std::array<Vector<Real>, kMaxFunctions> l; // lower triangle of G/W = L L^T, functions in use
        Vector<Real> inverse;                      // of the diagonal
        Vector<Real> y;                            // L^-1 g_y
    };
    // Sets `suffices` to whether the precision of Real does.
    template <class Real> Moments<Real> moments(int64_t k, bool &suffices) const noexcept;
    template <class Real> const Factor<Real> &factor() const noexcept;
    template <class Real> Vector<Real> solve_forward(const Real *sums) const noexcept;
    Vector<Quad> solve_back(const Vector<Quad> &x) const noexcept;
    void decompose(const BasisSums &sums) noexcept;
    void add_function(size_t f, Quad diagonal, Quad prior, Vector<Quad> &row) noexcept;
    void set_inverse() noexcept;
    void set_shared(Quad square) noexcept;
    template <class Real> void set_noise(const Vector<Real> &c, const Vector<Real> &s, Moments<Real> &m) const noexcept;

    const Stream &stream_;
    Quad part_; // 1/W
    size_t used_ = 0, free_ = 0;
    std::array<size_t, kMaxFunctions> index_{};
    Factor<Quad> quad_{};
    Factor<long double> long_double_{};
    std::array<Vector<Quad>, kMaxFunctions> inverse_{}; // L^-1
    long double spread_ = 0, value_size_ = 0;
    long double samples_over_weight_ = 0;
    bool needs_quad_ = false;   // at all frequencies
    bool vectorisable_ = false; // where cosine and sine keep their digits
    kernels::PowerRowsShared shared_{};
};

} // namespace toliman::period
