// A table of wavelengths and one value each: the spectrum of a star, a throughput, a quantum efficiency, the response
// of a photometric band. Two columns of text, separated by a comma or blanks, with wavelengths that increase or
// decrease. Blank lines and lines that begin with # are skipped. The first other line may be a header
// (spectrum_columns.hpp); without it, the comment above the numbers is one if it reads as one, and in an ECSV file the
// comments may have the units.
#pragma once
#include <string>
#include <vector>

#include "scene/spectrum_columns.hpp"

namespace toliman {

class SpectrumTable {
  public:
    // Fails with Status::not_found, or with Status::format and file and line.
    explicit SpectrumTable(const std::string &path, Curve curve = Curve::flux);

    double first_nm() const noexcept { return wavelength_nm_.front(); }
    double last_nm() const noexcept { return wavelength_nm_.back(); }
    // Whether the wavelengths are in the table, up to the rounding of a conversion to nm.
    bool covers(double least_nm, double most_nm) const noexcept;
    const std::vector<double> &wavelength_nm() const noexcept { return wavelength_nm_; } // increasing
    // Value (of a flux: relative photons), by linear interpolation; constant beyond the first and the last wavelength.
    double at(double wavelength_nm) const noexcept;

  private:
    std::vector<double> wavelength_nm_, value_;
};

} // namespace toliman
