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

} // namespace

bool remark_if_coarse(const toliman::periodogram &periodogram, Progress &progress) {
    const toliman_period_sampling sampling = sampling_of(periodogram, nullptr);
    if ((sampling.flags & TOLIMAN_PERIOD_COARSE) == 0)
        return false;
    remark_coarse(periodogram, sampling, progress);
    return true;
}

void remark(const Periodogram &periodogram, const Series *series, Progress &progress) {
    if (periodogram.at_edge())
        progress.warn(kEdgeRemark);
    const toliman_period_sampling sampling = sampling_of(periodogram.handle, series);
    if ((sampling.flags & TOLIMAN_PERIOD_COARSE) != 0)
        remark_coarse(periodogram.handle, sampling, progress);
    if (series != nullptr && (sampling.flags & TOLIMAN_PERIOD_PAST_CEILING) != 0) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "the grid goes beyond 1/(2 median dt) = %g, where even samples repeat what is below",
                      sampling.ceiling);
        progress.warn(text);
    }
}

} // namespace cli
