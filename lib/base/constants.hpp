// Mathematical constants. Kernels may include it.
#pragma once

namespace toliman {

constexpr long double kLongPi = 3.14159265358979323846264338327950288L;
constexpr double kPi = static_cast<double>(kLongPi);
constexpr double kDegree = kPi / 180, kArcsec = kPi / 648000; // rad

} // namespace toliman
