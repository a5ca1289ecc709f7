// How many digits a number is printed with.
#pragma once
#include <string>

namespace cli {

// Power of ten of its first digit once it is rounded to `digits` digits; of a finite number.
int exponent_of(double value, int digits);

// Decimals of a value that is known to `error`: those of two digits of the error, `least` at least, as in
// 2.59931 +- 0.00042 and 363.11 +- 3.13; where the error is unknown `least`, or two if that is less.
int decimals_of(double error, int least = 2);

// "363.1 +- 3.1", "3.012e-07 +- 4.0e-09"; six digits of a value where the error is 0, infinite or NaN, which is left
// out.
std::string text_with_error(double value, double error);

} // namespace cli
