// Goodness of fit of the frames of a folder.
#pragma once
#include "track/tracker.hpp"

namespace toliman::track {

// toliman_track_goodness; of the frames that are accepted or unreduced and have a chi-square.
struct FolderGoodness {
    // Medians of chi-square and its sigma, of misfits and outliers if there are no others; the largest residual.
    Goodness goodness;
    int64_t frames = 0, poor = 0, too_good = 0, bad_pixels = 0, cleaned = 0;
    double years = 0;                                                 // from the first to the last
    double trend_per_year = std::numeric_limits<double>::quiet_NaN(); // of chi-square
    double trend_sigma_per_year = std::numeric_limits<double>::quiet_NaN();
};

FolderGoodness folder_goodness(const Tracker &tracker);

} // namespace toliman::track
