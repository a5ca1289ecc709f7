// Photon spectrum of a black body (Planck's law).
#pragma once

namespace toliman::kernels {

// Given     wavelength_m > 0, temperature_k > 0
// Returned  photons per unit wavelength, time and area, in arbitrary units: lambda^-4/(exp(h c/(lambda k T)) - 1), with
//           lambda in micrometres
// Notes     0 where the exponential overflows. Constants are those of the 2019 SI, which are exact.
double blackbody_photons(double wavelength_m, double temperature_k) noexcept;

// Its logarithmic derivative by the temperature, per K.
double blackbody_rate(double wavelength_m, double temperature_k) noexcept;

} // namespace toliman::kernels
