// Chooses the number of digits with which a value is printed.
#pragma once
#include <string>

namespace cli {

// Decimal exponent of a finite number after rounding to `digits` digits.
int exponent_of(double value, int digits);

// Decimals of a value with standard error `error`: those of two digits of the error, but at least `least`, as in
// 2.59931 +- 0.00042 and 363.11 +- 3.13. If the error is unknown: the larger of `least` and 2.
int decimals_of(double error, int least = 2);

// "363.1 +- 3.1", "3.012e-07 +- 4.0e-09". The value has six digits if the error is 0, infinite or NaN; a NaN error is
// left out.
std::string text_with_error(double value, double error);

} // namespace cli
