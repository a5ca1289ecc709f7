// Merges a stream with other references (time_offset, value_offset, value_bound, sigma_floor) by re-referencing its
// sums.
// Method: with t' = t + T, v' = s v + h and w' = g w, the sums transform linearly. With z = exp(2 pi i f T):
//   C1' + i S1' = g (C1 + i S1) z;  C2' + i S2' = g (C2 + i S2) z^2;  YC' + i YS' = (g s (YC + i YS) + h g (C1 + i S1))
//      z.
// All products are formed in 113 bits (__float128), and z is normalised to the unit circle to 1e-33: the small
// eigenvalues of clustered times come from sums that cancel in more digits than long double has.
// Error: one unit of the lowest limb per sum, not per sample, since each new sum is rounded once; and 1e-19 relative,
// from the angle of z. Unlike a merge of equal grids, the result is not bit-identical to pushing all samples into one
// stream.
#include <cmath>

#include "base/error.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

namespace {

// Maps the other stream's terms to this stream's references; values in units of value_bound.
struct Reference {
    double time_high, time_low;    // t' = t + time_high + time_low
    Quad value_scale, value_shift; // v' = v value_scale + value_shift
    Quad weight_scale;             // w' = w weight_scale
};

// Cosine and sine of the rotation 2 pi (f0 + k df) T, to 1e-19.
void rotation_at(double f0, double df, int64_t k, const Reference &to, Quad &cosine, Quad &sine) noexcept {
    const Quad f = static_cast<Quad>(f0) + static_cast<Quad>(df) * static_cast<Quad>(k);
    const Quad cycles = f * (static_cast<Quad>(to.time_high) + static_cast<Quad>(to.time_low));
    const Quad rest = cycles - static_cast<Quad>(std::nearbyint(static_cast<long double>(cycles)));
    const long double angle = static_cast<long double>(rest) * 6.283185307179586476925286766559L;
    const auto c = static_cast<Quad>(std::cos(angle)), s = static_cast<Quad>(std::sin(angle));
    // Normalised to the unit circle to 1e-33. The error of the angle is then a common shift of all times, to which the
    // power is invariant.
    const Quad norm = 1 + (1 - c * c - s * s) / 2;
    cosine = c * norm;
    sine = s * norm;
}

// Adds the integer part of x 2^50 to a carry-save pair. Returns the fraction, which is the x of the next finer limb.
Quad add_limb(Quad x, int64_t &lo, int64_t &hi) noexcept {
    constexpr Quad kBase = static_cast<Quad>(0x1p32);
    const Quad scaled = x * static_cast<Quad>(kernels::kOne);
    auto upper = static_cast<int64_t>(scaled / kBase);
    const auto lower = static_cast<int64_t>(scaled - static_cast<Quad>(upper) * kBase); // both towards 0
    lo += lower;
    hi += upper;
    return scaled - static_cast<Quad>(upper) * kBase - static_cast<Quad>(lower);
}

} // namespace

// Fails unless the re-referenced sums stay within 2^50 per sample. Since sum w |v| <= W rms(v), the root mean square of
// the values decides, not the largest one. Likewise the mean weight decides: re-quantising has an error of 2^-50 per
// sum, not per sample, so that single light samples lose nothing.
void Stream::check_fit(Quad mean_square, Quad mean_weight) const {
    const double rms = std::sqrt(static_cast<double>(mean_square)), weight = static_cast<double>(mean_weight);
    if (!(rms <= 1))
        fail(Status::range,
             "merge: the root mean square of the other's values about value_offset = %.9g is %.9g: must be at most "
             "{value_bound} = %.9g",
             grid_.value_offset, rms * grid_.value_bound, grid_.value_bound);
    constexpr double kRounding = 1 + 1e-12;
    const double sigma = grid_.sigma_floor / std::sqrt(weight);
    if (!(sigma * kRounding >= grid_.sigma_floor && sigma <= grid_.sigma_ceiling * kRounding))
        fail(Status::range,
             "merge: the other's mean sigma = %.9g: must be in [sigma_floor, sigma_ceiling], {sigma_floor} = %.9g, "
             "sigma_ceiling = %.9g",
             sigma, grid_.sigma_floor, grid_.sigma_ceiling);
}

void Stream::merge_rereferenced(const Stream &other) {
    const Grid &from = other.grid_;
    if (from.basis.any() || grid_.basis.any())
        fail(Status::mismatch, "merge: with nuisance functions, grid and options must equal the other's");
    if (from.f0 != grid_.f0 || from.df != grid_.df || from.nf != grid_.nf || from.fixed_mean != grid_.fixed_mean)
        fail(Status::mismatch,
             "merge: the grids differ: %lld frequencies %g + k %g%s, the other %lld frequencies %g + k %g%s", //
             static_cast<long long>(grid_.nf), grid_.f0, grid_.df, grid_.fixed_mean ? ", fixed mean" : "",
             static_cast<long long>(from.nf), from.f0, from.df, from.fixed_mean ? ", fixed mean" : "");
    if (from.time_offset_ns != grid_.time_offset_ns || from.unit_ns != grid_.unit_ns)
        fail(Status::mismatch,
             "merge: {time_offset_ns} = %lld, unit_ns = %.17g: must equal the other's, %lld and %.17g",
             static_cast<long long>(grid_.time_offset_ns), grid_.unit_ns, static_cast<long long>(from.time_offset_ns),
             from.unit_ns);
    if (other.totals_.count == 0)
        return;
    if (grid_.double_limb() && !from.double_limb())
        fail(Status::mismatch, "merge: the other has single-limb accumulators, this one double-limb: create both with "
                               "TOLIMAN_PERIOD_DOUBLE_LIMB");

    Reference to = {};
    to.time_high = from.time_offset - grid_.time_offset;
    const Quad time = static_cast<Quad>(from.time_offset) - static_cast<Quad>(grid_.time_offset);
    to.time_low = static_cast<double>(time - static_cast<Quad>(to.time_high));
    const Quad floors = static_cast<Quad>(grid_.sigma_floor) / static_cast<Quad>(from.sigma_floor);
    to.weight_scale = floors * floors;
    to.value_scale = static_cast<Quad>(from.value_bound) / static_cast<Quad>(grid_.value_bound);
    to.value_shift = (static_cast<Quad>(from.value_offset) - static_cast<Quad>(grid_.value_offset)) /
                     static_cast<Quad>(grid_.value_bound);

    const Totals &more = other.totals_;
    const Quad weight = more.w.value(), wy = more.wy.value(), wyy = more.wyy.value();
    const Quad scale = to.value_scale, shift = to.value_shift;
    const Quad squares = scale * (scale * wyy + 2 * shift * wy) + shift * shift * weight; // sum of w v'^2
    check_fit(squares / weight, to.weight_scale * weight / static_cast<Quad>(more.count));

    rereferenced_ = true;
    fold();
    // Adds a re-referenced sum at frequency k to its limbs, coarsest first: each limb takes the integer part, the next
    // one the fraction. Single-limb accumulators lack the finer limbs; what would go there is the rounding error.
    const auto add_to_limbs = [this](size_t k, Quad value, std::initializer_list<kernels::Sum> limbs) {
        Quad fraction = value;
        for (const kernels::Sum limb : limbs) {
            if (limb >= grid_.sums())
                continue;
            const size_t at = static_cast<size_t>(limb) * padded() + k;
            fraction = add_limb(fraction, lo_[at], hi_[at]);
        }
    };
    using namespace kernels;
    for (int64_t k = 0; k < grid_.nf; k++) {
        const SumsAt<Quad> s = other.sums<Quad>(k);
        Quad re, im; // z
        rotation_at(grid_.f0, grid_.df, k, to, re, im);
        const Quad re2 = re * re - im * im, im2 = 2 * re * im; // z^2
        const Quad w = to.weight_scale, y = w * scale;
        const Quad c1 = w * (s.c1 * re - s.s1 * im), s1 = w * (s.s1 * re + s.c1 * im);
        const auto at = static_cast<size_t>(k);
        add_to_limbs(at, c1, {kC1, kC1Low});
        add_to_limbs(at, s1, {kS1, kS1Low});
        add_to_limbs(at, w * (s.c2 * re2 - s.s2 * im2), {kC2, kC2Low});
        add_to_limbs(at, w * (s.s2 * re2 + s.c2 * im2), {kS2, kS2Low});
        add_to_limbs(at, y * (s.yc * re - s.ys * im) + shift * c1, {kYC, kYCLow, kYCLowest});
        add_to_limbs(at, y * (s.ys * re + s.yc * im) + shift * s1, {kYS, kYSLow, kYSLowest});
    }

    // Scalars from the exact sums. Single-limb queries also use the quantised W and Wy, which match C1 and YC at f = 0.
    totals_.w.add_quad(to.weight_scale * weight);
    totals_.wy.add_quad(to.weight_scale * (scale * wy + shift * weight));
    totals_.wyy.add_quad(to.weight_scale * squares);
    totals_.wt.add_quad(to.weight_scale * (more.wt.value() + time * weight));
    totals_.wtt.add_quad(to.weight_scale * (more.wtt.value() + time * (2 * more.wt.value() + time * weight)));
    if (grid_.double_limb())
        return;
    const Quad rounded = other.weight();
    add_limb(to.weight_scale * rounded, totals_.weight, totals_.weight_high);
    const Quad rest =
        add_limb(to.weight_scale * (scale * other.mean_sum() + shift * rounded), totals_.value, totals_.value_high);
    add_limb(rest, totals_.value_low, totals_.value_low_high);
}

} // namespace toliman::period
