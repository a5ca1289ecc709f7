// Curves of a page: series and periodograms, whatever made them.
#pragma once
#include <string>
#include <vector>

#include "report/figure.hpp"

namespace cli {

using Numbers = std::vector<double>;

// At most `most` of them, evenly chosen.
Numbers thinned(const Numbers &values, size_t most);
// About the mean, over the standard deviation.
Numbers standardised(Numbers values);
// Means of `count` equal intervals of t, those without samples left out.
struct Means {
    Numbers t, y;
};
Means means_of(const Numbers &t, const Numbers &y, size_t count);

// A periodogram and what stands out.
struct PowerCurve {
    std::string name; // what the values are
    Numbers frequency, power;
    double peak_frequency = 0, fwhm = 0; // NaN or 0: not marked
    double level = 0;                    // of FAP 1e-3; NaN or 0: not marked
    std::string peak_label;
};

// One above the other. unit: "1/day".
Figure power_figure(const std::string &name, const std::string &caption, const std::string &unit,
                    const std::vector<PowerCurve> &curves);

} // namespace cli
