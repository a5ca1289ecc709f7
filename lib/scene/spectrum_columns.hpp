// The units of a spectrum, as its header names them.
#pragma once
#include <cstddef>
#include <string>

namespace toliman {

struct SpectrumColumns {
    double nm = 1;         // in the unit of the wavelengths
    int photons_power = 0; // photons per wavelength are flux times wavelength to this power
};

// Of a header such as wavelength_nm,relative_photon_flux or "Wavelength (Angstrom), flam". A wavelength without a unit
// is in nm, a flux without one in photons. path, line: of the header, for messages. Status::format for a name that is
// none of these: a spectrum in another unit would be read as one in nm.
SpectrumColumns spectrum_columns(const std::string &header, const std::string &path, size_t line);

} // namespace toliman
