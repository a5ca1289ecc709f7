// Measurements that do not belong to a series, and the goodness of a fit of the others.
#pragma once
#include <vector>

#include "base/goodness.hpp"
#include "planet/design.hpp"

namespace toliman::planet {

// Values without what the functions describe, in units of y, at all measurements, those left out included. design: of
// the functions and the values.
Buffer<double> residuals_of(const Series &series, const std::vector<const Function *> &functions,
                            const Buffer<double> &values, const Design &design);

// Marks residuals that are farther than any noise: beyond 6 robust standard deviations, which are at least the sigmas.
// None are marked if a fifth or more of all is: then it is the model that does not belong.
std::vector<bool> far_residuals(const Series &series, const Buffer<double> &residuals);

// Robust standard deviation of residuals in units of the sigmas, at least 1; without sigmas in units of y.
double scale_of(const Series &series, const Buffer<double> &residuals);

// Marks measurements that are far from a robust fit of the functions of the series and the best sinusoid.
std::vector<bool> screen(Series series, double frequency_min, double frequency_max);

// Rms of the residuals of the series itself, with the weights of the design.
double rms_of(const Series &series, const Design &design) noexcept;
// Weighted rms about the mean of each instrument. Of a period of twice the series, a trend leaves 1/19 of the
// amplitude: scales from the rms about all functions would lead to too short a period.
double spread_of(const Series &series, const Buffer<double> &values);

// Residuals of the series itself over the sigmas, without a jitter; unknown without sigmas. design: of the fit.
Goodness series_goodness(const Series &series, const Buffer<double> &residuals, const Design &design,
                         bool with_left_out);

// Of the measurements in use, with the jitter of the design.
Goodness goodness_with_jitter(const Series &series, const Design &design);

} // namespace toliman::planet
