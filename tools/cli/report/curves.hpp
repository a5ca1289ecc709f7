// Curves of a page: series and periodograms, whatever made them.
#pragma once
#include <string>
#include <vector>

#include "report/page.hpp"

namespace cli {

// At most `most` of them, evenly chosen.
Numbers thinned(const Numbers &values, size_t most);
// What a caption says of that; "" where all are kept.
std::string thinning_remark(size_t count, size_t most);

// Where samples of a sinusoid stand: along time or, where that shows nothing, folded over one period.
struct TimeAxis {
    Numbers x;
    double first = 0, last = 0;
    bool folded = false;
};
// Folded where t spans more than 16 periods or a period has less than `least` samples.
TimeAxis time_axis(const Numbers &t, double period, double least);

// Means over `count` equal intervals of the axis, those without samples left out.
struct Means {
    Numbers x, y;
};
Means means_of(const TimeAxis &axis, const Numbers &y, size_t count);

// A periodogram and what stands out.
struct PowerCurve {
    std::string name; // what the values are
    Numbers frequency, power;
    double peak_frequency = 0, fwhm = 0; // NaN or 0: not marked
    double level = 0;                    // of FAP 1e-3; NaN or 0: not marked
    std::string peak_label;
};

// One above the other, of one grid; a sentence where that has no width. unit: "1/day".
void add_power_figure(const std::string &name, const std::string &caption, const std::string &unit,
                      const std::vector<PowerCurve> &curves, Page &page);

} // namespace cli
