// How the instrument changes over the frames of a state folder: goodness of fit, pointing, fluxes and the other
// parameters that are fitted to each frame.
#pragma once
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/json.hpp"

namespace cli {

// A quantity of the frames as a function of time. Robust: frames beyond 6 standard deviations of the median are left
// out.
struct InstrumentTrend {
    std::string name, unit; // of the column and the parameter; "" if relative
    double median, rms;     // rms: robust standard deviation about the median
    double per_year;        // slope of a line
    double sigma_per_year;  // from the scatter about the line, of independent frames
    double years, scatter;  // of the frames: first to last; about the line

    // Over the years it changes by more than the scatter of frames, and not by chance.
    bool is_significant() const;
};

// Of the accepted and unreduced frames, for chi-square, pointing and parameters that vary; none for fewer than 20
// frames or 0.05 years.
std::vector<InstrumentTrend> trends_of(const toliman::tracker &tracker);

// The same columns of these frames, after their time "t" (time_of); none for fewer than 20 frames.
struct FrameColumn {
    std::string name;
    std::vector<double> values;
};
std::vector<FrameColumn> frames_over_time(const toliman::tracker &tracker);

// Lines of `status`: pointing, fluxes, focus and jitter, others if they are significant.
std::string text_of(const std::vector<InstrumentTrend> &trends);
std::vector<Json> json_of(const std::vector<InstrumentTrend> &trends);

} // namespace cli
