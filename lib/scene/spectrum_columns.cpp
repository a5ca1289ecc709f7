// Method: the words of each name decide. The photons of a spectrum per wavelength are its energy per wavelength times
// the wavelength, or its energy per frequency divided by it.
#include "scene/spectrum_columns.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace toliman {

namespace {

struct Unit {
    double nm;
    std::string_view names;
};
constexpr Unit kUnits[] = {
    {1, " nm nanometer nanometers nanometre nanometres "},
    {0.1, " a aa angstrom angstroms ang \xc3\x85 \xc3\xa5 "}, // Å, å
    {1e3, " um micron microns micrometer micrometers micrometre micrometres \xc2\xb5m \xce\xbcm "},
    {1e9, " m meter meters metre metres "},
};
constexpr std::string_view kWavelength = " wavelength wavelengths wave lambda wl lam vac vacuum in ",
                           kNeutral = " flux relative normalized normalised density spectrum spectral per in ",
                           kPhotons = " photon photons photlam ph ",
                           kEnergy = " flam erg ergs w watt watts j joule joules ",
                           kPerFrequency = " fnu jy mjy jansky hz ",
                           kOfUnits =
                               " s sec second m2 cm2 m cm nm a aa angstrom um micron 1 2 \xc2\xb5m \xce\xbcm \xc3\x85 ";

// In lists of words between spaces.
bool has(std::string_view list, const std::string &word) {
    return list.find(" " + word + " ") != std::string_view::npos;
}

bool is_letter(char c) noexcept {
    const auto byte = static_cast<unsigned char>(c);
    return (byte >= 'a' && byte <= 'z') || (byte >= '0' && byte <= '9') || byte >= 0x80;
}

std::vector<std::string> words_of(std::string_view name) {
    std::vector<std::string> words(1);
    for (char c : name) {
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        if (is_letter(c))
            words.back() += c;
        else if (!words.back().empty())
            words.emplace_back();
    }
    if (words.back().empty())
        words.pop_back();
    return words;
}

struct Place {
    const std::string &path;
    size_t line;
};

[[noreturn]] void refuse(std::string_view name, const Place &at, const char *must) {
    fail(Status::format, "{%s}: line %zu: the column \"%.*s\": must be %s", at.path.c_str(), at.line,
         static_cast<int>(name.size()), name.data(), must);
}

double nm_of(std::string_view name, const Place &at) {
    double nm = 0;
    for (const std::string &word : words_of(name)) {
        const Unit *const unit =
            std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit &one) { return has(one.names, word); });
        if (unit == std::end(kUnits) ? !has(kWavelength, word) : nm != 0)
            refuse(name, at, "wavelength_nm, or in angstrom, um or m");
        nm = unit == std::end(kUnits) ? nm : unit->nm;
    }
    return nm != 0 ? nm : 1;
}

int photons_power_of(std::string_view name, const Place &at) {
    bool photons = false, energy = false, per_frequency = false;
    for (const std::string &word : words_of(name)) {
        photons |= has(kPhotons, word);
        energy |= has(kEnergy, word);
        per_frequency |= has(kPerFrequency, word);
        if (!has(kPhotons, word) && !has(kEnergy, word) && !has(kPerFrequency, word) && !has(kNeutral, word) &&
            !has(kOfUnits, word))
            refuse(name, at, "relative_photon_flux, or energy: flam, fnu");
    }
    if (photons && (energy || per_frequency))
        refuse(name, at, "of photons or of energy");
    return per_frequency ? -1 : energy ? 1 : 0;
}

} // namespace

SpectrumColumns spectrum_columns(const std::string &header, const std::string &path, size_t line) {
    const size_t comma = header.find(',');
    if (comma == std::string::npos || header.find(',', comma + 1) != std::string::npos)
        fail(Status::format,
             "{%s}: line %zu: must be two names, such as wavelength_nm,relative_photon_flux, or two numbers",
             path.c_str(), line);
    const std::string_view text = header;
    const Place at = {path, line};
    return {nm_of(text.substr(0, comma), at), photons_power_of(text.substr(comma + 1), at)};
}

} // namespace toliman
