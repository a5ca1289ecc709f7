// expm1 keeps the Rayleigh-Jeans regime accurate, where exp(x) - 1 would cancel.
#include "kernels/blackbody.hpp"

#include <cmath>

namespace toliman::kernels {

namespace {

// h c/(k lambda T)
double energy(double wavelength_m, double temperature_k) noexcept {
    constexpr double planck = 6.62607015e-34, light = 299792458.0, boltzmann = 1.380649e-23;
    return planck * light / (wavelength_m * boltzmann * temperature_k);
}

} // namespace

double blackbody_photons(double wavelength_m, double temperature_k) noexcept {
    const double micrometres = wavelength_m * 1e6, square = micrometres * micrometres;
    return 1.0 / (square * square * std::expm1(energy(wavelength_m, temperature_k)));
}

double blackbody_rate(double wavelength_m, double temperature_k) noexcept {
    const double u = energy(wavelength_m, temperature_k);
    return u / (-std::expm1(-u) * temperature_k);
}

} // namespace toliman::kernels
