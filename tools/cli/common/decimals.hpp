// How many digits a number is printed with.
#pragma once

namespace cli {

// Power of ten of its first digit once it is rounded to `digits` digits; of a finite number.
int exponent_of(double value, int digits);

// Decimals of a value that is known to `error`: those of two digits of the error, `least` at least, as in
// 2.59931 +- 0.00042 and 363.11 +- 3.13.
int decimals_of(double error, int least = 2);

} // namespace cli
