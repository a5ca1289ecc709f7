// Streaming periodogram: grid, order-free exact sums of all samples pushed, checks of samples and sums.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "base/buffer.hpp"
#include "base/quad.hpp"
#include "kernels/push_rows.hpp"
#include "period/stream/basis.hpp"
#include "period/stream/exact_sum.hpp"

namespace toliman::period {

// Largest ratio of two sigmas. The weight of the largest sigma keeps 40 bits in single-limb accumulators, 47 bits in
// double-limb ones.
constexpr double kSingleLimbSigmaRatio = 32, kMaxSigmaRatio = 1e8;
// With weight 1 the upper part of an accumulator reaches 2^61: two sums of this size fit.
constexpr int64_t kMaxSamples = int64_t{1} << 43;
constexpr double kMaxTime = 1e100; // the square is summed exactly and must not overflow

// Frequencies f0 + k df, k < nf, and every other option that determines the bits of the sums.
struct Grid {
    double f0 = 0, df = 0;
    int64_t nf = 0;
    bool fixed_mean = false, double_limb_sums = false;
    double time_offset = 0, value_offset = 0;
    int64_t time_offset_ns = 0; // reference of times given in nanoseconds
    double unit_ns = 1e9;       // nanoseconds per unit of time
    double value_bound = 0x1p20;
    double sigma_floor = 1;
    double sigma_ceiling = 0; // 0: the largest that single-limb accumulators carry
    Basis basis;              // nuisance functions

    void check() const;
    void check_options() const; // of all but f0, df and nf
    uint64_t digest() const;
    // Requested, or required because the weights span too large a range for a resolution of 2^-50, or because nuisance
    // functions are projected out: every accumulator then has one limb (50 bits) more.
    bool double_limb() const noexcept {
        return double_limb_sums || sigma_ceiling > kSingleLimbSigmaRatio * sigma_floor || basis.any();
    }
    size_t sums() const noexcept {
        return double_limb() ? kernels::kSums + (basis.functions() - 1) * kernels::kFunctionSums
                             : kernels::kSingleLimbSums;
    }
    double last() const noexcept { return f0 + df * static_cast<double>(nf - 1); }
};

// Sums at one frequency: weights in units of the weight of sigma_floor, values in units of value_bound.
template <class Real> struct SumsAt { Real c1, s1, c2, s2, yc, ys; };

constexpr double kUnit = 0x1p-50, kLowUnit = 0x1p-100, kLowestUnit = 0x1p-150; // units of the three limbs

template <class Real> Real carry_save_value(int64_t lo, int64_t hi) noexcept {
    return static_cast<Real>(hi) * static_cast<Real>(0x1p32) + static_cast<Real>(lo);
}

// Sums that do not depend on the frequency. The quantised ones round each term as the single-limb C1 and YC do at
// f = 0.
struct Totals {
    int64_t count = 0;
    int64_t weight = 0, weight_high = 0;       // quantised at 2^-50, carry-save as in kernels/push.hpp
    int64_t value = 0, value_high = 0;         // w y, likewise
    int64_t value_low = 0, value_low_high = 0; // remainder of w y at 2^-100
    ExactSum w, wy, wyy, wt, wtt;              // exact: w, w y, w y^2, w t, w t^2 (offsets subtracted)
};

// A sample. Its time is relative to the grid's reference, t_high + t_low as an unevaluated sum; t is the time as given,
// for messages.
struct Sample {
    double t, t_high, t_low, y, sigma;
    bool unweighted = false;         // given without a sigma: has the weight of sigma_floor
    const double *columns = nullptr; // [grid.basis.columns]
};

// "sample 3: " for messages; empty below 0, of a single sample.
std::string prefix_of_sample(int64_t index);

class Stream {
  public:
    explicit Stream(const Grid &grid);

    // Makes a sample at the time t + low, or at t_ns nanoseconds.
    Sample sample(double t, double low, double y, double sigma) const noexcept;
    Sample sample_ns(int64_t t_ns, double y, double sigma) const noexcept;

    // Returns whether the sample's time is within 2^50 cycles of the reference, so that its phases are reduced exactly,
    // and in the span of the trend, and its columns, if it has any, are within their bounds.
    bool covers(const Sample &sample) const noexcept;
    // Fails unless the sample can be pushed; the message names it by its index where index >= 0.
    void check(const Sample &sample, int64_t index) const;
    // Returns whether the totals satisfy the bounds of every set of samples: W <= count, Cauchy-Schwarz for values and
    // times; to 1e-9, for the rounding of re-referenced sums.
    bool consistent() const noexcept;
    // Fails with Status::state unless they do: a sample was retracted that was never pushed.
    void check_consistent() const;
    // Adds a checked sample. Does not allocate.
    void push(const Sample &sample) noexcept { add(sample, 1); }
    // Removes a checked sample that was pushed: the sums become bit-identical to never having pushed it.
    void retract(const Sample &sample) noexcept { add(sample, -1); }
    void reset() noexcept;

    // Adds all samples of another stream. Exact if the digests of the grids are equal. Otherwise the other's sums are
    // re-referenced first, with an error of 2^-50 per sum (2^-100, 2^-150 with more limbs) and 1e-19 relative.
    // Status::mismatch for other frequencies or another kind of mean; Status::range if the root mean square of the
    // other's values or its mean weight is outside this stream's bounds.
    void merge(const Stream &other);

    const Grid &grid() const noexcept { return grid_; }
    Memory memory() const noexcept { return lo_.get_allocator().memory(); }
    const Totals &totals() const noexcept { return totals_; }
    // The sums at frequency k. long double suffices for single-limb accumulators; double-limb ones may lose more digits
    // by cancellation than it has.
    template <class Real> SumsAt<Real> sums(int64_t k) const noexcept;
    // The sums w b cos and w b sin of the functions at frequency k, [basis.functions()] each; those of function 0 are
    // C1 and S1.
    template <class Real> void function_sums(int64_t k, Real *c, Real *s) const noexcept;
    const BasisSums &basis_sums() const noexcept { return basis_sums_; }
    // Lower and upper part of an accumulator (kernels::Sum), from frequency k.
    const int64_t *low(size_t sum, int64_t k) const noexcept {
        return lo_.data() + sum * padded() + static_cast<size_t>(k);
    }
    const int64_t *high(size_t sum, int64_t k) const noexcept {
        return hi_.data() + sum * padded() + static_cast<size_t>(k);
    }
    Quad weight() const noexcept;   // W
    Quad mean_sum() const noexcept; // Wy, in units of value_bound
    // Returns whether some sample has a weight other than 1. No weight exceeds 1, so W = count only if all are 1.
    bool weighted() const noexcept { return totals_.w.value() != static_cast<Quad>(totals_.count); }
    // Returns whether a sample may have been retracted that was never pushed: after retract() or load().
    bool retracted() const noexcept { return retracted_; }
    // Returns whether re-referenced sums were merged. Their accuracy is that of the other stream, which is not known
    // here, so checks of consistency are looser.
    bool rereferenced() const noexcept { return rereferenced_; }
    // Returns whether some sample was given without a sigma. Not part of the state bytes: false after load().
    bool unweighted() const noexcept { return unweighted_ > 0; }
    // Variance of the values about their mean, in units of value_bound squared; 0 if they are constant.
    long double spread() const noexcept;
    long double time_variance() const noexcept;

    // State bytes (tools/docs/formats.md, "TLMP"). Status::state for sums that no set of samples has: load() would
    // refuse them.
    std::vector<uint8_t> save() const;
    static Stream load(const void *bytes, size_t size);
    size_t saved_size() const noexcept;
    // Size of the complete state bytes with this header; size >= kHeaderSize.
    static size_t saved_size(const void *header, size_t size);
    static constexpr size_t kHeaderSize = 4 + 4 + 4 + 4 + 10 * 8 + 8; // without the basis
    static std::vector<uint8_t> header(const Grid &grid);
    // Size of a header that begins with these kHeaderSize bytes.
    static size_t header_size(const void *start);
    static Grid load_header(const void *header, size_t size);

  private:
    void add(const Sample &sample, double sign) noexcept;
    void add_sample(const kernels::PushSample &sample) noexcept;
    void add_row(const Sample &given, const kernels::PushSample &sample) noexcept;
    bool is_within_cycles(const Sample &sample) const noexcept;
    bool is_in_span(const Sample &sample) const noexcept;
    bool are_within_bounds(const double *columns) const noexcept;
    void check_basis(const Sample &sample, int64_t index) const;
    template <class Real> Real sum_at(size_t sum, int64_t k, double unit) const noexcept {
        return carry_save_value<Real>(*low(sum, k), *high(sum, k)) * static_cast<Real>(unit);
    }
    void merge_exact(const Stream &other) noexcept;
    void merge_rereferenced(const Stream &other);
    void check_sums() const;
    void check_fit(Quad mean_square, Quad mean_weight) const;
    // An odd number of blocks: rows a power of two apart would map to the same few cache sets.
    size_t padded() const noexcept { return (blocks_ | 1) * kernels::kBlock; }
    void fold() noexcept;

    Grid grid_;
    Totals totals_;
    BasisSums basis_sums_;
    size_t blocks_;
    int pending_ = 0;
    int64_t unweighted_ = 0; // samples given without a sigma since creation or load
    bool retracted_ = false, rereferenced_ = false;
    Buffer<int64_t> lo_, hi_; // [grid_.sums()][padded]
    Buffer<double> anchors_;
};

// Checks that all samples of a periodogram have a sigma, or none. An unweighted sample has the weight of sigma_floor;
// among weighted samples that would be a weight that nobody chose. A sigma equal to sigma_floor is allowed with both.
class WeightingCheck {
  public:
    explicit WeightingCheck(const Stream &stream) noexcept : stream_(stream), unweighted_(stream.unweighted()) {}
    // Fails with Status::state if the sample mixes the two kinds; the message names it by its index where index >= 0.
    void check(const Sample &sample, int64_t index);

  private:
    const Stream &stream_;
    bool unweighted_;
    std::optional<bool> weighted_; // computed on first use
};

} // namespace toliman::period
