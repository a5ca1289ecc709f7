
#include "api/spread.hpp"
#include "api/common.hpp"

namespace toliman::api {

namespace {

constexpr double kMostVariance = 4, kMostFrames = 1e12;
constexpr double kRounding = 1e-9;

} // namespace

Spread spread_of(const toliman_spread *given, const char *name) {
    static_assert(kCumulants == TOLIMAN_SPREAD_CUMULANTS);
    Spread spread;
    if (given == nullptr)
        return spread;
    const toliman_spread known = copied(given, name);
    if (known.reserved != 0)
        fail(Status::argument, "{%s->reserved} = %u: must be 0", name, known.reserved);
    if (!(known.frames == 0 || (known.frames >= 1 && known.frames <= kMostFrames)))
        fail(Status::argument, "{%s->frames} = %g: must be in [1, %g], or 0 for 1", name, known.frames, kMostFrames);
    for (const auto &[member, value] : {std::pair("xx_px2", known.xx_px2), {"yy_px2", known.yy_px2}})
        if (!(value >= 0 && value <= kMostVariance))
            fail(Status::argument, "{%s->%s} = %g: must be in [0, %g] px^2", name, member, value, kMostVariance);
    if (!(known.xy_px2 * known.xy_px2 <= known.xx_px2 * known.yy_px2 * (1 + kRounding)))
        fail(Status::argument, "{%s->xy_px2} = %g: its square must be at most xx_px2 yy_px2 = %g", name, known.xy_px2,
             known.xx_px2 * known.yy_px2);
    for (size_t i = 0; i < kCumulants; i++) {
        const double value = known.cumulants[i];
        if (!std::isfinite(value))
            fail(Status::argument, "{%s->cumulants[%zu]} = %g: must be finite", name, i, value);
        if (value != 0 && known.xx_px2 == 0 && known.yy_px2 == 0)
            fail(Status::argument, "{%s->cumulants[%zu]} = %g: must be 0 without a covariance", name, i, value);
        spread.cumulants[i] = value;
    }
    spread.frames = known.frames != 0 ? known.frames : 1;
    spread.xx = known.xx_px2;
    spread.yy = known.yy_px2;
    spread.xy = known.xy_px2;
    return spread;
}

toliman_spread public_spread(const Spread &spread) noexcept {
    toliman_spread out = {};
    out.struct_size = sizeof out;
    out.frames = spread.frames;
    out.xx_px2 = spread.xx;
    out.yy_px2 = spread.yy;
    out.xy_px2 = spread.xy;
    std::copy(spread.cumulants.begin(), spread.cumulants.end(), out.cumulants);
    return out;
}

} // namespace toliman::api
