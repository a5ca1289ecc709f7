// Streaming periodogram: the exact sums of all samples pushed so far.
#pragma once
#include <cstdint>
#include <optional>

#include "base/buffer.hpp"
#include "base/quad.hpp"
#include "kernels/push.hpp"
#include "period/exact_sum.hpp"

namespace toliman::period {

constexpr double kSingleLimbRatio = 32;            // of sigmas, in narrow sums: weights keep 40 bits
constexpr double kMostRatio = 1e8;                 // in wide sums: weights keep 47 bits
constexpr int64_t kMostSamples = int64_t{1} << 43; // of weight 1 fill a sum to 2^61, and leave room for as many more
constexpr double kMostTime = 1e100;                // its square must have an exact sum

// Frequencies f0 + k df, k < nf, and everything else that the bits of the sums depend on.
struct Grid {
    double f0 = 0, df = 0;
    int64_t nf = 0;
    bool fixed_mean = false, double_limb_sums = false;
    double time_offset = 0, value_offset = 0;
    int64_t time_offset_ns = 0; // of times in nanoseconds, and how many of those a unit of time has
    double unit_ns = 1e9;
    double value_bound = 0x1p20;
    double sigma_floor = 1;
    double sigma_ceiling = 0; // 0 becomes the largest that narrow sums carry

    void check() const;
    uint64_t digest() const;
    // Asked for, or weights too different for sums of 2^-50: every sum has its lower limb.
    bool double_limb() const noexcept { return double_limb_sums || sigma_ceiling > kSingleLimbRatio * sigma_floor; }
    size_t sums() const noexcept { return double_limb() ? size_t{kernels::kSums} : kernels::kSingleLimbSums; }
    double last() const noexcept { return f0 + df * static_cast<double>(nf - 1); }
};

// Sums of one frequency in units of one sample of weight 1; values in units of value_bound.
template <class Real> struct SumsAt { Real c1, s1, c2, s2, yc, ys; };

// Sums that no frequency enters. The quantised ones are sums of the same terms as C1 and YC of narrow sums at f = 0.
struct Totals {
    int64_t count = 0;
    int64_t weight = 0, weight_high = 0;       // quantised at 2^-50, carry-save as in kernels/push.hpp
    int64_t value = 0, value_high = 0;         // w y, the same
    int64_t value_low = 0, value_low_high = 0; // its remainder at 2^-100
    ExactSum w, wy, wyy, wt, wtt;              // exact: w, w y, w y^2, w t, w t^2 (offsets subtracted)
};

// A sample, its time already counted from the grid's reference, as an unevaluated sum; t is what messages call it.
struct Sample {
    double t, t_high, t_low, y, sigma;
    bool unweighted = false; // came without a sigma, and counts as sigma_floor
};

class Stream {
  public:
    explicit Stream(const Grid &grid);

    // Samples with the time t, t + low, or in nanoseconds.
    Sample sample(double t, double low, double y, double sigma) const noexcept;
    Sample sample_ns(int64_t t_ns, double y, double sigma) const noexcept;

    // Whether the sums have a place for its time.
    bool reaches(const Sample &sample) const noexcept;
    // Fails with the sample's number (when index >= 0) unless it can be pushed.
    void check(const Sample &sample, int64_t index) const;
    // Whether samples can have the totals: within the bounds of any multiset of samples, widened by 1e-9 for sums that
    // were turned.
    bool possible() const noexcept;
    // Fails with Status::state unless they can: a sample was taken back that never came.
    void check_possible() const;
    // Takes a checked sample. Allocates nothing.
    void push(const Sample &sample) noexcept { add(sample, 1); }
    // Takes a checked sample back that was pushed: all sums are then as if it had not been.
    void retract(const Sample &sample) noexcept { add(sample, -1); }
    void reset() noexcept;

    // Adds all samples of another stream: exactly where the grids are equal, else turned to this one's references, with
    // errors of 2^-50 a sum (2^-100, 2^-150 where there are more limbs) and of 1e-19 of it. Status::mismatch for other
    // frequencies or kinds of mean, Status::range where the other's values or weights do not fit in the mean.
    void merge(const Stream &other);

    const Grid &grid() const noexcept { return grid_; }
    Memory memory() const noexcept { return lo_.get_allocator().memory(); }
    const Totals &totals() const noexcept { return totals_; }
    // long double holds narrow sums; wide ones may cancel in more digits than it has.
    template <class Real> SumsAt<Real> sums(int64_t k) const noexcept;
    // Both parts of a sum, from frequency k on.
    const int64_t *low(size_t sum, int64_t k) const noexcept {
        return lo_.data() + sum * padded() + static_cast<size_t>(k);
    }
    const int64_t *high(size_t sum, int64_t k) const noexcept {
        return hi_.data() + sum * padded() + static_cast<size_t>(k);
    }
    Quad weight() const noexcept;   // W
    Quad mean_sum() const noexcept; // Wy, in units of value_bound
    Quad mean() const noexcept;     // Wy/W
    // Whether a sample's weight is not 1: none is above.
    bool weighted() const noexcept { return totals_.w.value() != static_cast<Quad>(totals_.count); }
    // Whether a sample may have been taken back that never came: by retract, here or before the state was saved.
    bool taken_back() const noexcept { return taken_back_; }
    // Whether sums of other references were merged: they are as exact as those were, which these totals do not tell.
    bool turned() const noexcept { return turned_; }
    // Whether some sample came without a sigma, as far as is known: state bytes do not tell.
    bool unweighted() const noexcept { return unweighted_ > 0; }
    // Variance of the values about their mean, in units of value_bound squared; 0 if they are constant.
    long double spread() const noexcept;
    long double time_variance() const noexcept;

    // Bytes of tools/docs/formats.md, "TLMP". Status::state for sums that no samples have, which could not be loaded
    // again.
    std::vector<uint8_t> save() const;
    static Stream load(const void *bytes, size_t size);
    size_t saved_size() const noexcept;
    // The size that state bytes must have which begin with these, kHeaderSize or more.
    static size_t saved_size(const void *header, size_t size);
    static constexpr size_t kHeaderSize = 4 + 4 + 4 + 4 + 10 * 8 + 8;
    static std::vector<uint8_t> header(const Grid &grid);
    static Grid load_header(const void *header, size_t size);

  private:
    void add(const Sample &sample, double sign) noexcept;
    void merge_equal(const Stream &other) noexcept;
    void merge_turned(const Stream &other);
    void check_sums() const;
    void check_fit(Quad mean_square, Quad mean_weight) const;
    // Odd blocks: sums a power of two apart would share few lines of the caches.
    size_t padded() const noexcept { return (blocks_ | 1) * kernels::kBlock; }
    void fold() noexcept;

    Grid grid_;
    Totals totals_;
    size_t blocks_;
    int pending_ = 0;
    int64_t unweighted_ = 0; // samples, as far as is known
    bool taken_back_ = false, turned_ = false;
    Buffer<int64_t> lo_, hi_; // [grid_.sums()][padded]
    Buffer<double> anchors_;
};

// Samples of one periodogram all have a sigma, or none has: unweighted ones count as sigma_floor, which beside others
// would be a weight that nobody chose. Sigmas of sigma_floor go with both.
class OneWeighting {
  public:
    explicit OneWeighting(const Stream &stream) noexcept : stream_(stream), unweighted_(stream.unweighted()) {}
    // Fails with Status::state, and the sample's number (when index >= 0), unless it is of the kind of those before.
    void check(const Sample &sample, int64_t index);

  private:
    const Stream &stream_;
    bool unweighted_;
    std::optional<bool> weighted_; // asked for when it matters
};

} // namespace toliman::period
