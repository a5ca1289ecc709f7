// The photons of a star by wavelength, as they arrive at the telescope: in the scene's samples, and anywhere.
#pragma once
#include <optional>
#include <vector>

#include "scene/scene.hpp"
#include "scene/spectrum_table.hpp"

namespace toliman::optics {

struct Sample {
    double wavelength_nm, weight;
};

// The band's wavelengths with trapezium weights.
std::vector<Sample> sample_band(const Band &band);

// A continuous spectrum without its modes.
class Continuum {
  public:
    explicit Continuum(const Spectrum &spectrum);

    double at(double wavelength_nm) const noexcept;                               // relative photons per wavelength
    const std::optional<SpectrumTable> &table() const noexcept { return table_; } // none of a black body

  private:
    const Spectrum &spectrum_;
    std::optional<SpectrumTable> table_;
};

// Relative photons of a star at the wavelengths of the scene.
std::vector<Sample> sample_star(const Scene &scene, size_t star);

// Logarithmic derivatives of a star's spectrum at a wavelength: per K of its temperature, and per unit of the
// coefficient of a spectral mode.
double temperature_rate(const Scene &scene, size_t star, double wavelength_m) noexcept;
double mode_rate(const Scene &scene, size_t star, int number, double wavelength_m);

} // namespace toliman::optics
