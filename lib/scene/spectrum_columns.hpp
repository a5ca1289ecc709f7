// The columns of a table of wavelengths, as its header names them.
#pragma once
#include <cstddef>
#include <string>

namespace toliman {

// What the second column of a table is: photons or energy of a star, the fraction of the light that passes a part of
// the telescope, electrons per photon, or the relative response of a photometric band to photons.
enum class Curve { flux, throughput, qe, response };

struct SpectrumColumns {
    double nm = 0;         // in the unit of the wavelengths; 0: the header names none
    int photons_power = 0; // photons per wavelength are flux times wavelength to this power
};

// Of a header such as wavelength_nm,relative_photon_flux or "Wavelength (Angstrom), flam"; without a comma, blanks
// separate the names. A flux without a unit is in photons. path, line: of the header, for messages. Status::format for
// a name that is none of these: a spectrum in another unit would be read as one in nm.
SpectrumColumns spectrum_columns(const std::string &header, Curve curve, const std::string &path, size_t line);

} // namespace toliman
