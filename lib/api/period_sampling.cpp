// include/toliman/period_sampling.h
#include <toliman/period_sampling.h>

#include "api/common.hpp"
#include "api/handles.hpp"
#include "api/peak.hpp"
#include "period/alias.hpp"
#include "period/sampling.hpp"
#include "period/stream/power.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

constexpr Choice<period::Cause> kIntervals = {TOLIMAN_PERIOD_INTERVAL_SAMPLING, TOLIMAN_PERIOD_INTERVAL_YEAR,
                                              "TOLIMAN_PERIOD_INTERVAL_..."};

toliman_period_alias public_alias(const period::Alias &alias) noexcept {
    toliman_period_alias out = {};
    out.interval_kind = kIntervals.to_constant(alias.cause);
    TOLIMAN_COPY(out, alias, frequency, interval, window, power, equal, slow, parts);
    out.period = 1 / alias.frequency;
    return out;
}

} // namespace

extern "C" {

toliman_status toliman_period_query_sampling(const toliman_period *period, const double *t, size_t n,
                                             toliman_period_sampling *out) noexcept {
    return query(period, "period", out, [&](auto &self, auto &sampling) {
        const period::Stream &stream = self.stream;
        const period::Cadence cadence = t != nullptr ? period::cadence_of(stream, t, n) : period::cadence_of(stream);
        const period::Grid &grid = stream.grid();
        sampling.baseline = cadence.span;
        sampling.coarsest_df = 1 / (5 * cadence.span);
        sampling.nyquist = 1 / (2 * cadence.finest);
        sampling.independent = std::max(1.0, grid.last() * cadence.span);
        const period::PowerQuery query(stream);
        const double nyquist = t != nullptr ? sampling.nyquist : 1 / (2 * period::even_step(stream));
        sampling.flags = grid_flags(grid, cadence) |
                         (query.needs_double_limb() ? TOLIMAN_PERIOD_NEEDS_DOUBLE_LIMB : 0) |
                         (query.any_inaccurate(nyquist) ? TOLIMAN_PERIOD_INACCURATE : 0);
    });
}

toliman_status toliman_period_query_aliases(const toliman_period *period, double frequency,
                                            toliman_period_alias *aliases, size_t capacity, size_t *count) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        const StructOutput<toliman_period_alias> results(aliases, "aliases", capacity, count);
        const period::Grid &grid = stream.grid();
        if (!(frequency >= grid.f0 && frequency <= grid.last()))
            fail(Status::argument, "{frequency} = %g: must be in the grid, [%g, %g]", frequency, grid.f0, grid.last());
        period::Alias found[period::kMaxAliases];
        results.write(period::find_aliases(stream, frequency, found), "aliases",
                      [&](size_t i) { return public_alias(found[i]); });
    });
}

} // extern "C"
