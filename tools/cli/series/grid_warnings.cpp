#include "series/grid_warnings.hpp"

#include "common/text.hpp"

namespace cli {

namespace {

toliman_period_sampling sampling_of(const toliman::periodogram &periodogram, const Series *series) {
    auto sampling = toliman::sized<toliman_period_sampling>();
    toliman::check(toliman_period_query_sampling(periodogram.get(), series != nullptr ? series->t.data() : nullptr,
                                                 series != nullptr ? series->t.size() : 0, &sampling));
    return sampling;
}

void warn_coarse(const toliman::periodogram &periodogram, const toliman_period_sampling &sampling, Progress &progress) {
    progress.warn(formatted("--df %g is above 1/(5 T) = %g, so peaks between two frequencies may be missed",
                            info_of(periodogram).df, sampling.coarsest_df));
}

void warn_inaccurate(const toliman::periodogram &periodogram, Progress &progress) {
    const bool wide = (info_of(periodogram).flags & TOLIMAN_PERIOD_DOUBLE_LIMB) != 0;
    progress.warn(
        std::string("the power may be wrong by more than 0.001 at some frequencies, where the samples cover "
                    "too small a part of a cycle: ") +
        (wide ? "give another first frequency (--f0)" : "the sums of the state lack TOLIMAN_PERIOD_DOUBLE_LIMB"));
}

} // namespace

void warn_while_following(const toliman::periodogram &periodogram, uint32_t &warned, Progress &progress) {
    constexpr uint32_t all = TOLIMAN_PERIOD_COARSE | TOLIMAN_PERIOD_INACCURATE;
    if ((warned & all) == all)
        return;
    const toliman_period_sampling sampling = sampling_of(periodogram, nullptr);
    const uint32_t fresh = sampling.flags & all & ~warned;
    if ((fresh & TOLIMAN_PERIOD_COARSE) != 0)
        warn_coarse(periodogram, sampling, progress);
    if ((fresh & TOLIMAN_PERIOD_INACCURATE) != 0)
        warn_inaccurate(periodogram, progress);
    warned |= fresh;
}

void warn_of_grid(const Periodogram &periodogram, const Series *series, Progress &progress) {
    if (periodogram.at_edge())
        progress.warn(kEdgeWarning);
    const toliman_period_sampling sampling = sampling_of(periodogram.handle, series);
    if ((sampling.flags & TOLIMAN_PERIOD_COARSE) != 0)
        warn_coarse(periodogram.handle, sampling, progress);
    if (((sampling.flags | periodogram.peak.flags) & TOLIMAN_PERIOD_INACCURATE) != 0)
        warn_inaccurate(periodogram.handle, progress);
    if (series != nullptr && (sampling.flags & TOLIMAN_PERIOD_ABOVE_NYQUIST) != 0)
        progress.warn(
            formatted("the grid exceeds 1/(2 median dt) = %g: evenly spaced samples repeat lower frequencies there",
                      sampling.nyquist));
}

} // namespace cli
