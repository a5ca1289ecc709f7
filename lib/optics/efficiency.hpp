// What becomes of the light in the instrument, by wavelength: telescope.throughput, and detector.qe if it is a file.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "scene/spectrum_table.hpp"

namespace toliman::optics {

class Efficiency {
  public:
    explicit Efficiency(const Scene &scene); // scene must outlive the object

    // The product of all factors. Status::scene where a file does not cover the wavelength.
    double throughput(double wavelength_nm) const;
    // Electrons per photon, above 0; 1 without a file.
    double qe(double wavelength_nm) const;

  private:
    double value(const SpectrumTable &table, const std::string &key, double wavelength_nm) const;

    const Scene &scene_;
    std::vector<std::optional<SpectrumTable>> tables_; // of the factors of the throughput that are files
    std::optional<SpectrumTable> qe_;
};

} // namespace toliman::optics
