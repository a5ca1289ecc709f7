// Method: order-free exact sums of the generalised Lomb-Scargle periodogram (Zechmeister and Kuerster 2009, A&A 496,
// 577). With w = (sigma_floor/sigma)^2, v = (y - value_offset)/value_bound, p = (f0 + k df) (t - time_offset) modulo 1:
//   C1, S1 = sum w cos, sin 2 pi p;  C2, S2 = sum w cos, sin 4 pi p;  YC, YS = sum w v cos, sin 2 pi p.
// Each term is rounded to 2^-50 and added as an integer. The remainder of a term with v goes to a second limb at
// 2^-100; double-limb accumulators have one limb more. Integer addition is associative: every order of samples, split
// into shards and merge gives the same bits, and retract() undoes push() exactly, which the tracker needs to quarantine
// a frame.
// Rejected: compensated sums of doubles, whose last bits depend on the order, so that a retraction does not restore
// them; a superaccumulator per sum, 560 bytes each (ExactSum), against 128 bytes for the eight carry-save pairs of a
// frequency.
// Measured: 1.0 ns per frequency and push on AVX-512, plain double sums 0.9 ns.
// Error: half a unit of the last limb per sample, and 4e-16 of cosine and sine (phases in plain double: 3e-10 to 8e-9).
#include "period/stream/stream.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"

namespace toliman::period {

namespace {

constexpr int64_t kMaxFrequencies = int64_t{1} << 26;
constexpr double kMaxCycles = 0x1p50;
constexpr double kMinSquarable = 1e-130; // smaller numbers have no exact square in double, and are negligible

// a - b as an unevaluated sum (Knuth's TwoSum).
void difference(double a, double b, double &high, double &low) noexcept {
    high = a - b;
    const double back = high - a;
    low = (a - (high - back)) - (b + back);
}

int64_t quantise(double x) noexcept {
    return static_cast<int64_t>(std::nearbyint(x));
}

void fold_pair(int64_t &lo, int64_t &hi) noexcept {
    hi += lo >> 32;
    lo &= kernels::kFoldBase - 1;
}

} // namespace

std::string prefix_of_sample(int64_t index) {
    return index >= 0 ? "sample " + std::to_string(index) + ": " : "";
}

void Grid::check() const {
    if (!(std::isfinite(f0) && f0 >= 0))
        fail(Status::argument, "{f0} = %g: must be finite and at least 0", f0);
    if (!(std::isfinite(df) && df > 0))
        fail(Status::argument, "{df} = %g: must be finite and above 0", df);
    if (nf < 1 || nf > kMaxFrequencies)
        fail(Status::argument, "{nf} = %lld: must be in [1, %lld]", static_cast<long long>(nf),
             static_cast<long long>(kMaxFrequencies));
    if (!std::isfinite(last()))
        fail(Status::argument, "{f0} + (nf - 1) df: must be finite");
    if (!(last() > 0))
        fail(Status::argument, "{f0} = 0, nf = 1: the grid must have a frequency above 0");
    check_options();
}

void Grid::check_options() const {
    if (!(unit_ns >= 1 && unit_ns <= 1e30))
        fail(Status::argument, "{unit_ns} = %g: must be in [1, 1e30]", unit_ns);
    if (!std::isfinite(time_offset) || !std::isfinite(value_offset))
        fail(Status::argument, "{%s} = %g: must be finite", std::isfinite(time_offset) ? "value_offset" : "time_offset",
             std::isfinite(time_offset) ? value_offset : time_offset);
    if (!(value_bound >= 1e-100 && value_bound <= 1e100))
        fail(Status::argument, "{value_bound} = %g: must be in [1e-100, 1e100]", value_bound);
    if (!(sigma_floor >= 1e-100 && sigma_floor <= 1e100))
        fail(Status::argument, "{sigma_floor} = %g: must be in [1e-100, 1e100]", sigma_floor);
    if (!(sigma_ceiling >= sigma_floor))
        fail(Status::argument, "{sigma_ceiling} = %g: must be at least sigma_floor = %g, or 0 for %g times that",
             sigma_ceiling, sigma_floor, kSingleLimbSigmaRatio);
    if (!(sigma_ceiling <= kMaxSigmaRatio * sigma_floor * (1 + 1e-12)))
        fail(Status::range, "{sigma_ceiling} = %g, sigma_floor = %g: the ratio must be at most %g", sigma_ceiling,
             sigma_floor, kMaxSigmaRatio);
    if (fixed_mean && basis.any())
        fail(Status::argument, "{flags}: a fixed mean is not supported with a trend, columns or priors");
    basis.check();
}

uint64_t Grid::digest() const {
    ByteWriter identity;
    for (double value : {f0, df, time_offset, value_offset, value_bound, sigma_floor, sigma_ceiling})
        identity.f64(value);
    identity.i64(time_offset_ns);
    identity.f64(unit_ns);
    identity.i64(nf);
    identity.u8(static_cast<uint8_t>((fixed_mean ? 1 : 0) | (double_limb() ? 2 : 0)));
    if (basis.any()) {
        identity.u8(static_cast<uint8_t>(basis.trend));
        identity.u8(static_cast<uint8_t>(basis.columns));
        basis.save(identity);
    }
    return fnv1a(reinterpret_cast<const char *>(identity.bytes().data()), identity.bytes().size());
}

static Grid completed(Grid grid) {
    if (grid.sigma_ceiling == 0)
        grid.sigma_ceiling = kSingleLimbSigmaRatio * grid.sigma_floor;
    grid.check();
    return grid;
}

Stream::Stream(const Grid &grid) : grid_(completed(grid)), basis_sums_(grid_.basis.functions()) {
    blocks_ = (static_cast<size_t>(grid_.nf) + kernels::kBlock - 1) / kernels::kBlock;
    lo_.resize(grid_.sums() * padded());
    hi_.resize(grid_.sums() * padded());
    anchors_.resize(2 * blocks_);
}

Sample Stream::sample(double t, double low, double y, double sigma) const noexcept {
    Sample sample = {t, 0, 0, y, sigma};
    double rest;
    difference(t, grid_.time_offset, sample.t_high, rest);
    difference(sample.t_high, -(rest + low), sample.t_high, sample.t_low);
    return sample;
}

Sample Stream::sample_ns(int64_t t_ns, double y, double sigma) const noexcept {
    const __int128 elapsed = static_cast<__int128>(t_ns) - grid_.time_offset_ns;
    const auto high = static_cast<double>(elapsed);
    const auto low = static_cast<double>(elapsed - static_cast<__int128>(high));
    Sample sample = {static_cast<double>(t_ns), high / grid_.unit_ns, 0, y, sigma};
    sample.t_low = (std::fma(-sample.t_high, grid_.unit_ns, high) + low) / grid_.unit_ns;
    return sample;
}

bool Stream::is_within_cycles(const Sample &sample) const noexcept {
    const double elapsed = std::fabs(sample.t_high);
    return elapsed <= kMaxTime && elapsed * grid_.last() <= kMaxCycles;
}

bool Stream::covers(const Sample &sample) const noexcept {
    return is_within_cycles(sample) && is_in_span(sample) &&
           (sample.columns == nullptr || are_within_bounds(sample.columns));
}

void Stream::check(const Sample &sample, int64_t index) const {
    const double t = sample.t, y = sample.y, sigma = sample.sigma, elapsed = std::fabs(sample.t_high);
    const auto where = [index] { return prefix_of_sample(index); };
    if (!std::isfinite(t) || std::isnan(elapsed + sample.t_low))
        fail(Status::argument, "%s{t} = %g: must be finite", where().c_str(), t);
    if (!std::isfinite(y))
        fail(Status::argument, "%s{y} = %g: must be finite", where().c_str(), y);
    if (!(std::isfinite(sigma) && sigma > 0))
        fail(Status::argument, "%s{sigma} = %g: must be finite and above 0", where().c_str(), sigma);
    if (!(elapsed <= kMaxTime))
        fail(Status::range, "%s{t} = %g: must be within %g of time_offset = %g", where().c_str(), t, kMaxTime,
             grid_.time_offset);
    if (!is_within_cycles(sample))
        fail(Status::range, "%s{t} = %g: must be within 2^50 cycles of time_offset", where().c_str(), t);
    if (!(std::fabs(y - grid_.value_offset) <= grid_.value_bound))
        fail(Status::range, "%s{y} = %g: must be within value_bound = %g of value_offset = %g, both fixed at creation",
             where().c_str(), y, grid_.value_bound, grid_.value_offset);
    if (sigma < grid_.sigma_floor)
        fail(Status::range, "%s{sigma} = %g: must be at least sigma_floor = %g, the smallest sigma, fixed at creation",
             where().c_str(), sigma, grid_.sigma_floor);
    if (sigma > grid_.sigma_ceiling)
        fail(Status::range, "%s{sigma} = %g: must be at most sigma_ceiling = %g, the largest sigma, fixed at creation",
             where().c_str(), sigma, grid_.sigma_ceiling);
    check_basis(sample, index);
    if (totals_.count + std::max<int64_t>(0, index) >= kMaxSamples)
        fail(Status::range, "%stoo many samples: must be at most %lld", where().c_str(),
             static_cast<long long>(kMaxSamples));
}

void WeightingCheck::check(const Sample &sample, int64_t index) {
    if (sample.unweighted && stream_.grid().basis.has_priors())
        fail(Status::argument, "{sigma}: must be given with prior_precision, whose unit is that of absolute sigmas");
    if (sample.unweighted) {
        unweighted_ = true;
        if (!weighted_)
            weighted_ = stream_.weighted();
    } else if (sample.sigma != stream_.grid().sigma_floor) {
        weighted_ = true;
    }
    if (unweighted_ && weighted_.value_or(false))
        fail(Status::state, "%s%s: all samples must have a {sigma}, or none", prefix_of_sample(index).c_str(),
             sample.unweighted ? "has no sigma, but other samples have one"
                               : "has a sigma, but other samples have none");
}

bool Stream::consistent() const noexcept {
    constexpr Quad kRounding = static_cast<Quad>(1e-9);
    const auto n = static_cast<Quad>(totals_.count), slack = kRounding * std::max<Quad>(n, 1);
    const Quad w = totals_.w.value(), wy = totals_.wy.value(), wyy = totals_.wyy.value(), wt = totals_.wt.value(),
               wtt = totals_.wtt.value();
    return (totals_.count > 0 ? w > 0 : w >= -slack) && w <= n + slack && wyy >= -slack && wyy <= w + slack &&
           wy * wy <= (w + slack) * (wyy + slack) &&
           (rereferenced_ || (wtt >= 0 && wt * wt <= (w + slack) * wtt * (1 + kRounding))) &&
           basis_sums_.consistent(w, wyy, slack);
}

void Stream::check_consistent() const {
    if (!consistent())
        fail(Status::state,
             "%lld samples would remain with sums of weights %g, values %g and squared values %g, which is impossible: "
             "a retracted sample was never pushed",
             static_cast<long long>(totals_.count), static_cast<double>(totals_.w.value()),
             static_cast<double>(totals_.wy.value()), static_cast<double>(totals_.wyy.value()));
}

void Stream::add_sample(const kernels::PushSample &sample) noexcept {
    int64_t *rows[kernels::kSums];
    for (size_t i = 0; i < grid_.sums(); i++)
        rows[i] = lo_.data() + i * padded();
    const kernels::PushKernels &known = kernels::push_kernels();
    (grid_.double_limb() ? known.push_double_limb : known.push)(grid_.f0, grid_.df, blocks_, sample, anchors_.data(),
                                                                rows);
}

// Every term is odd in the weight, and so is its rounding: a sample of negative weight removes exactly what the sample
// of positive weight added.
void Stream::add(const Sample &given, double sign) noexcept {
    const double ratio = grid_.sigma_floor / given.sigma;
    kernels::PushSample sample = {};
    sample.t_high = given.t_high;
    sample.t_low = given.t_low;
    sample.weight = sign * ratio * ratio;
    double y_high, y_low;
    difference(given.y, grid_.value_offset, y_high, y_low);
    sample.value_high = y_high / grid_.value_bound;
    // The remainder of the division, exact by FMA, is added to the remainder of the difference.
    sample.value_low = (std::fma(-sample.value_high, grid_.value_bound, y_high) + y_low) / grid_.value_bound;

    if (grid_.basis.any())
        add_row(given, sample);
    else
        add_sample(sample);

    const double w = sample.weight, product = w * (sample.value_high * kernels::kOne);
    const double product_low =
        w * sample.value_low * kernels::kOne + std::fma(w, sample.value_high * kernels::kOne, -product);
    const double rounded = std::nearbyint(product);
    totals_.weight += quantise(w * kernels::kOne);
    totals_.value += quantise(product);
    totals_.value_low += quantise((product - rounded) * kernels::kOne + product_low * kernels::kOne);
    totals_.w.add(w);
    totals_.wy.add_product(w, sample.value_high);
    totals_.wy.add_product(w, sample.value_low);
    totals_.wyy.add_product_square(w, sample.value_high);
    totals_.wyy.add_product(2 * w * sample.value_low, sample.value_high);
    if (std::fabs(sample.value_low) > kMinSquarable)
        totals_.wyy.add_product_square(w, sample.value_low);
    totals_.wt.add_product(w, sample.t_high);
    totals_.wtt.add_product_square(w, sample.t_high);
    totals_.count += sign > 0 ? 1 : -1;
    retracted_ = retracted_ || sign < 0;
    if (given.unweighted)
        unweighted_ += sign > 0 ? 1 : -1;
    if (++pending_ == kernels::kFoldEvery)
        fold();
}

void Stream::fold() noexcept {
    kernels::push_kernels().fold(lo_.data(), hi_.data(), lo_.size());
    fold_pair(totals_.weight, totals_.weight_high);
    fold_pair(totals_.value, totals_.value_high);
    fold_pair(totals_.value_low, totals_.value_low_high);
    pending_ = 0;
}

void Stream::reset() noexcept {
    std::memset(lo_.data(), 0, lo_.size() * sizeof lo_[0]);
    std::memset(hi_.data(), 0, hi_.size() * sizeof hi_[0]);
    totals_ = Totals();
    basis_sums_.reset();
    pending_ = 0;
    unweighted_ = 0;
    retracted_ = rereferenced_ = false;
}

void Stream::merge(const Stream &other) {
    if (other.totals_.count > kMaxSamples - totals_.count)
        fail(Status::range, "merge: too many samples: must be at most %lld in total",
             static_cast<long long>(kMaxSamples));
    if ((unweighted() && other.weighted()) || (other.unweighted() && weighted()))
        fail(Status::mismatch, "merge: one periodogram has samples with sigmas, the other has samples without");
    if (other.grid_.digest() == grid_.digest())
        merge_exact(other);
    else
        merge_rereferenced(other);
    totals_.count += other.totals_.count;
    unweighted_ += other.unweighted_;
    retracted_ = retracted_ || other.retracted_;
    rereferenced_ = rereferenced_ || other.rereferenced_;
    fold();
}

void Stream::merge_exact(const Stream &other) noexcept {
    fold();
    for (size_t i = 0; i < lo_.size(); i++) { // the other's lower part is below 2^62 even if it is not folded
        lo_[i] += other.lo_[i];
        hi_[i] += other.hi_[i];
    }
    Totals &sums = totals_;
    const Totals &more = other.totals_;
    sums.weight += more.weight;
    sums.weight_high += more.weight_high;
    sums.value += more.value;
    sums.value_high += more.value_high;
    sums.value_low += more.value_low;
    sums.value_low_high += more.value_low_high;
    sums.w.add(more.w);
    sums.wy.add(more.wy);
    sums.wyy.add(more.wyy);
    sums.wt.add(more.wt);
    sums.wtt.add(more.wtt);
    basis_sums_.add(other.basis_sums_);
}

template <class Real> SumsAt<Real> Stream::sums(int64_t k) const noexcept {
    const auto at = [&](kernels::Sum sum, double unit) { return sum_at<Real>(sum, k, unit); };
    using namespace kernels;
    SumsAt<Real> sums = {at(kC1, kUnit),
                         at(kS1, kUnit),
                         at(kC2, kUnit),
                         at(kS2, kUnit),
                         at(kYC, kUnit) + at(kYCLow, kLowUnit),
                         at(kYS, kUnit) + at(kYSLow, kLowUnit)};
    if (grid_.double_limb()) {
        sums.c1 += at(kC1Low, kLowUnit);
        sums.s1 += at(kS1Low, kLowUnit);
        sums.c2 += at(kC2Low, kLowUnit);
        sums.s2 += at(kS2Low, kLowUnit);
        sums.yc += at(kYCLowest, kLowestUnit);
        sums.ys += at(kYSLowest, kLowestUnit);
    }
    return sums;
}
template SumsAt<long double> Stream::sums(int64_t) const noexcept;
#ifdef TOLIMAN_QUAD_IS_WIDER
template SumsAt<Quad> Stream::sums(int64_t) const noexcept;
#endif

// Single-limb: W and Wy are sums of the same rounded terms as C1 and YC at f = 0, so that moments about the mean vanish
// exactly where the cosine is constant. Double-limb: the exact sums.
Quad Stream::weight() const noexcept {
    return grid_.double_limb() ? totals_.w.value()
                               : carry_save_value<Quad>(totals_.weight, totals_.weight_high) * static_cast<Quad>(kUnit);
}

Quad Stream::mean_sum() const noexcept {
    return grid_.double_limb()
               ? totals_.wy.value()
               : carry_save_value<Quad>(totals_.value, totals_.value_high) * static_cast<Quad>(kUnit) +
                     carry_save_value<Quad>(totals_.value_low, totals_.value_low_high) * static_cast<Quad>(kLowUnit);
}

// E[x^2] - E[x]^2 in 113 bits. Where the difference cancels more than half of them, (W Wxx - Wx^2)/W^2 from exact
// products instead. 0 if all x are equal. (In double, an offset of 10^6 sigma made the variance wrong by 2e-4.)
static long double variance_of(const ExactSum &w, const ExactSum &wx, const ExactSum &wxx) noexcept {
    const Quad total = w.value(), average = wx.value() / total, square = wxx.value() / total;
    Quad variance = square - average * average;
    if (variance < square * static_cast<Quad>(0x1p-56)) {
        ExactSum rest;
        rest.add_product(w, wxx, 1);
        rest.add_product(wx, wx, -1);
        variance = rest.value() / total / total;
    }
    return variance > 0 ? static_cast<long double>(variance) : 0;
}

long double Stream::spread() const noexcept {
    return variance_of(totals_.w, totals_.wy, totals_.wyy);
}

long double Stream::time_variance() const noexcept {
    return variance_of(totals_.w, totals_.wt, totals_.wtt);
}

} // namespace toliman::period
