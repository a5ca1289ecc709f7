// Tables of a spectrum: lines of wavelength_nm,relative photon flux; # starts a comment, a line of words may head them.
#pragma once
#include <string>
#include <vector>

namespace toliman::optics {

class SpectrumTable {
  public:
    // Status::not_found or Status::format, with file and line.
    explicit SpectrumTable(const std::string &path);

    double first_nm() const noexcept { return wavelength_nm_.front(); }
    double last_nm() const noexcept { return wavelength_nm_.back(); }
    // Linear between the table's points; beyond first and last the value there.
    double at(double wavelength_nm) const noexcept;

  private:
    std::vector<double> wavelength_nm_, flux_;
};

} // namespace toliman::optics
