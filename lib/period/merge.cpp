// Sums of another reference, turned to this one's.
#include <cmath>

#include "base/error.hpp"
#include "period/stream.hpp"

namespace toliman::period {

namespace {

// What makes one stream's terms the other's.
struct Turn {
    double time_high, time_low; // t' = t + time
    Quad value_scale, value;    // v' = v value_scale + value, in units of the bounds
    Quad weight;                // w' = w weight
};

// Cosine and sine of 2 pi f t, to 1e-19.
void turn_of(double f0, double df, int64_t k, const Turn &turn, Quad &cosine, Quad &sine) noexcept {
    const Quad f = static_cast<Quad>(f0) + static_cast<Quad>(df) * static_cast<Quad>(k);
    const Quad cycles = f * (static_cast<Quad>(turn.time_high) + static_cast<Quad>(turn.time_low));
    const Quad rest = cycles - static_cast<Quad>(std::nearbyint(static_cast<long double>(cycles)));
    const long double angle = static_cast<long double>(rest) * 6.283185307179586476925286766559L;
    const auto c = static_cast<Quad>(std::cos(angle)), s = static_cast<Quad>(std::sin(angle));
    // On the unit circle to 1e-33: what is left of the error is a shift of all times, which no power feels.
    const Quad onto = 1 + (1 - c * c - s * s) / 2;
    cosine = c * onto;
    sine = s * onto;
}

// Adds x 2^50, less what stands in the limb above, to a carry-save pair; returns what is left for the limb below.
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

// That sums stay below 2^50 a sample: Sum w |v| <= W rms(v), and W below the number of samples. Quantising them anew
// costs 2^-50 a sum, not a sample, so that light weights must be so on average only.
void Stream::check_fit(Quad mean_square, Quad mean_weight) const {
    const double rms = std::sqrt(static_cast<double>(mean_square)), weight = static_cast<double>(mean_weight);
    if (!(rms <= 1))
        fail(Status::range,
             "merge: the other's values are %.9g from value_offset = %.9g in the root mean square, "
             "{value_bound} is %.9g",
             rms * grid_.value_bound, grid_.value_offset, grid_.value_bound);
    constexpr double kRounding = 1 + 1e-12;
    const double sigma = grid_.sigma_floor / std::sqrt(weight);
    if (!(sigma * kRounding >= grid_.sigma_floor && sigma <= grid_.sigma_ceiling * kRounding))
        fail(Status::range,
             "merge: the other's sigmas are %.9g on average, here {sigma_floor} = %.9g and sigma_ceiling = "
             "%.9g",
             sigma, grid_.sigma_floor, grid_.sigma_ceiling);
}

void Stream::merge_turned(const Stream &other) {
    const Grid &from = other.grid_;
    if (from.f0 != grid_.f0 || from.df != grid_.df || from.nf != grid_.nf || from.fixed_mean != grid_.fixed_mean)
        fail(Status::mismatch,
             "merge: a grid of %lld frequencies %g + k %g%s, the other has %lld, %g + k %g%s", //
             static_cast<long long>(grid_.nf), grid_.f0, grid_.df, grid_.fixed_mean ? ", fixed mean" : "",
             static_cast<long long>(from.nf), from.f0, from.df, from.fixed_mean ? ", fixed mean" : "");
    if (from.time_offset_ns != grid_.time_offset_ns || from.unit_ns != grid_.unit_ns)
        fail(Status::mismatch,
             "merge: {time_offset_ns} = %lld, unit_ns = %.17g, the other has %lld, %.17g: shards must share them",
             static_cast<long long>(grid_.time_offset_ns), grid_.unit_ns, static_cast<long long>(from.time_offset_ns),
             from.unit_ns);
    if (other.totals_.count == 0)
        return;
    if (grid_.double_limb() && !from.double_limb())
        fail(Status::mismatch,
             "merge: the other's sums are narrow, these are wide: make both with TOLIMAN_PERIOD_DOUBLE_LIMB");

    Turn turn = {};
    turn.time_high = from.time_offset - grid_.time_offset;
    const Quad time = static_cast<Quad>(from.time_offset) - static_cast<Quad>(grid_.time_offset);
    turn.time_low = static_cast<double>(time - static_cast<Quad>(turn.time_high));
    const Quad floors = static_cast<Quad>(grid_.sigma_floor) / static_cast<Quad>(from.sigma_floor);
    turn.weight = floors * floors;
    turn.value_scale = static_cast<Quad>(from.value_bound) / static_cast<Quad>(grid_.value_bound);
    turn.value = (static_cast<Quad>(from.value_offset) - static_cast<Quad>(grid_.value_offset)) /
                 static_cast<Quad>(grid_.value_bound);

    const Totals &more = other.totals_;
    const Quad weight = more.w.value(), wy = more.wy.value(), wyy = more.wyy.value();
    const Quad scale = turn.value_scale, shift = turn.value;
    const Quad squares =
        scale * (scale * wyy + 2 * shift * wy) + shift * shift * weight; // of w v'^2, v' in units of bound
    check_fit(squares / weight, turn.weight * weight / static_cast<Quad>(more.count));

    turned_ = true;
    fold();
    const auto add = [&](size_t sum, size_t k, Quad x, std::initializer_list<size_t> below) {
        x = add_limb(x, lo_[sum * padded() + k], hi_[sum * padded() + k]);
        for (const size_t next : below)
            if (next < grid_.sums())
                x = add_limb(x, lo_[next * padded() + k], hi_[next * padded() + k]);
    };
    using namespace kernels;
    for (int64_t k = 0; k < grid_.nf; k++) {
        const SumsAt<Quad> s = other.sums<Quad>(k);
        Quad c, i;
        turn_of(grid_.f0, grid_.df, k, turn, c, i);
        const Quad c2 = c * c - i * i, i2 = 2 * c * i, w = turn.weight, y = w * turn.value_scale;
        const Quad cosine = w * (s.c1 * c - s.s1 * i), sine = w * (s.s1 * c + s.c1 * i);
        const auto at = static_cast<size_t>(k);
        add(kC1, at, cosine, {kC1Low});
        add(kS1, at, sine, {kS1Low});
        add(kC2, at, w * (s.c2 * c2 - s.s2 * i2), {kC2Low});
        add(kS2, at, w * (s.s2 * c2 + s.c2 * i2), {kS2Low});
        add(kYC, at, y * (s.yc * c - s.ys * i) + turn.value * cosine, {kYCLow, kYCLowest});
        add(kYS, at, y * (s.ys * c + s.yc * i) + turn.value * sine, {kYSLow, kYSLowest});
    }

    // The scalars by their exact sums; of narrow sums the rounded ones, too, which C1 and YC follow at f = 0.
    totals_.w.add_quad(turn.weight * weight);
    totals_.wy.add_quad(turn.weight * (scale * wy + shift * weight));
    totals_.wyy.add_quad(turn.weight * squares);
    totals_.wt.add_quad(turn.weight * (more.wt.value() + time * weight));
    totals_.wtt.add_quad(turn.weight * (more.wtt.value() + time * (2 * more.wt.value() + time * weight)));
    if (grid_.double_limb())
        return;
    const Quad rounded = other.weight();
    add_limb(turn.weight * rounded, totals_.weight, totals_.weight_high);
    const Quad rest =
        add_limb(turn.weight * (scale * other.mean_sum() + shift * rounded), totals_.value, totals_.value_high);
    add_limb(rest, totals_.value_low, totals_.value_low_high);
}

} // namespace toliman::period
