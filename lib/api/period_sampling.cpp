// include/toliman/period_sampling.h
#include <algorithm>

#include <toliman/period_sampling.h>

#include "api/guard.hpp"
#include "api/handles.hpp"
#include "api/peak.hpp"
#include "period/power.hpp"
#include "period/sampling.hpp"

using namespace toliman;
using namespace toliman::api;

extern "C" {

toliman_status toliman_period_query_sampling(const toliman_period *period, const double *t, size_t n,
                                             toliman_period_sampling *out) noexcept {
    return guard([&] {
        const Use use(period, "period");
        const period::Stream &stream = use->stream;
        const period::Cadence cadence = t != nullptr ? period::cadence_of(stream, t, n) : period::cadence_of(stream);
        const period::Grid &grid = stream.grid();
        toliman_period_sampling sampling = {};
        sampling.baseline = cadence.span;
        sampling.coarsest_df = 1 / (5 * cadence.span);
        sampling.nyquist = 1 / (2 * cadence.step);
        sampling.independent = std::max(1.0, grid.last() * cadence.span);
        const period::PowerQuery query(stream);
        const double nyquist = t != nullptr ? sampling.nyquist : 1 / (2 * period::even_step(stream));
        sampling.flags = grid_flags(grid, cadence) |
                         (query.needs_double_limb() ? TOLIMAN_PERIOD_NEEDS_DOUBLE_LIMB : 0) |
                         (query.any_inaccurate(nyquist) ? TOLIMAN_PERIOD_INACCURATE : 0);
        deliver(sampling, out, "out");
    });
}

} // extern "C"
