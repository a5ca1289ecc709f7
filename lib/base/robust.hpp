// Median and robust scale of residuals, and the limit beyond which one of them does not belong.
#pragma once
#include <vector>

namespace toliman {

// Robust standard deviations beyond which a residual is an outlier: a Gaussian exceeds 6 once in 5e8.
constexpr double kOutlierSigmas = 6;

// The upper median; 0 without values.
double median(std::vector<double> values);

// 1.4826 median |residual|, which is the standard deviation of a Gaussian; 0 without residuals.
double robust_sigma(std::vector<double> residuals);

} // namespace toliman
