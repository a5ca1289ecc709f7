// Zernike polynomials in Noll's order.
#pragma once

namespace toliman::kernels {

constexpr int kLargestNoll = 231; // the last index of radial order 20

// Given     noll, index from 1 to kLargestNoll; x, y in units of the disc's radius
// Returned  the polynomial's value, of unit rms over the unit disc; NaN for another index
// Notes     Even indices have cos(m theta), odd ones sin(m theta), with theta from +x towards +y: 2 is 2x, 3 is 2y.
//           Outside the disc the polynomial is extended. Error below 1e-13 within the disc.
// Reference R. J. Noll, J. Opt. Soc. Am. 66, 207 (1976), equations 1 to 3 and table I; Abramowitz and Stegun (1964),
//           22.7.1
double zernike(int noll, double x, double y) noexcept;

} // namespace toliman::kernels
