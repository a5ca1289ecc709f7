// A spectrum from a CSV file with the columns wavelength and flux. Blank lines and lines that begin with # are skipped;
// the first other line may be a header, which may name other units than nm and photons (spectrum_columns.hpp).
#pragma once
#include <string>
#include <vector>

namespace toliman {

class SpectrumTable {
  public:
    // Fails with Status::not_found, or with Status::format and file and line.
    explicit SpectrumTable(const std::string &path);

    double first_nm() const noexcept { return wavelength_nm_.front(); }
    double last_nm() const noexcept { return wavelength_nm_.back(); }
    // Relative flux, by linear interpolation; constant beyond the first and the last wavelength.
    double at(double wavelength_nm) const noexcept;

  private:
    std::vector<double> wavelength_nm_, flux_;
};

} // namespace toliman
