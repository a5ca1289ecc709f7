#include "series/grid_remarks.hpp"

#include <cstdio>

namespace cli {

namespace {

toliman_period_sampling sampling_of(const toliman::periodogram &periodogram, const Series *series) {
    toliman_period_sampling sampling = {};
    sampling.struct_size = sizeof sampling;
    toliman::check(toliman_period_query_sampling(periodogram.get(), series != nullptr ? series->t.data() : nullptr,
                                                 series != nullptr ? series->t.size() : 0, &sampling));
    return sampling;
}

void remark_coarse(const toliman::periodogram &periodogram, const toliman_period_sampling &sampling,
                   Progress &progress) {
    char text[200];
    std::snprintf(text, sizeof text, "--df %g is above 1/(5 T) = %g: peaks may pass between two frequencies unseen",
                  info_of(periodogram).df, sampling.coarsest_df);
    progress.warn(text);
}

void remark_inaccurate(const toliman::periodogram &periodogram, Progress &progress) {
    const bool wide = (info_of(periodogram).flags & TOLIMAN_PERIOD_DOUBLE_LIMB) != 0;
    progress.warn(std::string("at some frequencies, where the samples cover too small a part of a cycle, the power may "
                              "be wrong by more than 0.001: ") +
                  (wide ? "--f0 gives another first frequency" : "the state's sums lack TOLIMAN_PERIOD_DOUBLE_LIMB"));
}

} // namespace

void remark_while_following(const toliman::periodogram &periodogram, uint32_t &told, Progress &progress) {
    constexpr uint32_t all = TOLIMAN_PERIOD_COARSE | TOLIMAN_PERIOD_INACCURATE;
    if ((told & all) == all)
        return;
    const toliman_period_sampling sampling = sampling_of(periodogram, nullptr);
    const uint32_t news = sampling.flags & all & ~told;
    if ((news & TOLIMAN_PERIOD_COARSE) != 0)
        remark_coarse(periodogram, sampling, progress);
    if ((news & TOLIMAN_PERIOD_INACCURATE) != 0)
        remark_inaccurate(periodogram, progress);
    told |= news;
}

void remark(const Periodogram &periodogram, const Series *series, Progress &progress) {
    if (periodogram.at_edge())
        progress.warn(kEdgeRemark);
    const toliman_period_sampling sampling = sampling_of(periodogram.handle, series);
    if ((sampling.flags & TOLIMAN_PERIOD_COARSE) != 0)
        remark_coarse(periodogram.handle, sampling, progress);
    if (((sampling.flags | periodogram.peak.flags) & TOLIMAN_PERIOD_INACCURATE) != 0)
        remark_inaccurate(periodogram.handle, progress);
    if (series != nullptr && (sampling.flags & TOLIMAN_PERIOD_ABOVE_NYQUIST) != 0) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "the grid goes beyond 1/(2 median dt) = %g, where even samples repeat what is below",
                      sampling.nyquist);
        progress.warn(text);
    }
}

} // namespace cli
