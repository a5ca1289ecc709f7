// Method: the words of each name decide. The photons of a spectrum per wavelength are its energy per wavelength times
// the wavelength, or its energy per frequency divided by it.
#include "scene/spectrum_columns.hpp"

#include <algorithm>
#include <string_view>
#include <utility>
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

// Words of columns that have no unit.
constexpr std::string_view kPassed = " throughput transmission transmissivity transmittance reflectance reflectivity "
                                     "reflection response ",
                           kDetected = " qe quantum efficiency ", kOf = " relative normalized normalised ";

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
    return nm;
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

// A column of numbers without a unit, of 1 at most.
void check_fraction(std::string_view name, Curve curve, const Place &at) {
    for (const std::string &word : words_of(name)) {
        const bool detected = has(kDetected, word);
        if (detected && curve == Curve::throughput)
            refuse(name, at, "throughput, transmission or reflectance; a quantum efficiency is detector.qe");
        const bool known = has(kOf, word) || (curve == Curve::qe ? detected : has(kPassed, word));
        if (!known || name.find('%') != std::string_view::npos)
            refuse(name, at, curve == Curve::qe ? "qe, from 0 to 1" : "throughput, from 0 to 1");
    }
}

constexpr std::string_view kBlanks = " \t";

// Both names of a header, between which there is one comma or, without any, blanks; blanks in front of brackets are
// part of a name. Empty if there are not two.
std::pair<std::string_view, std::string_view> names_of(std::string_view header) {
    const size_t comma = header.find(',');
    if (comma != std::string_view::npos)
        return header.find(',', comma + 1) != std::string_view::npos
                   ? std::pair<std::string_view, std::string_view>()
                   : std::pair(header.substr(0, comma), header.substr(comma + 1));
    const auto end_of_name = [&](size_t at) {
        for (at = header.find_first_of(kBlanks, at); at != std::string_view::npos;) {
            const size_t next = header.find_first_not_of(kBlanks, at);
            if (next == std::string_view::npos || (header[next] != '(' && header[next] != '['))
                return next;
            const size_t closed = header.find_first_of(")]", next);
            at = closed == std::string_view::npos ? closed : header.find_first_of(kBlanks, closed);
        }
        return at;
    };
    const size_t second = end_of_name(0);
    if (second == std::string_view::npos || end_of_name(second) != std::string_view::npos)
        return {};
    return {header.substr(0, second), header.substr(second)};
}

} // namespace

SpectrumColumns spectrum_columns(const std::string &header, Curve curve, const std::string &path, size_t line) {
    const auto [wavelength, value] = names_of(header);
    if (value.empty())
        fail(Status::format, "{%s}: line %zu: must be two names, such as wavelength_nm,%s, or two numbers",
             path.c_str(), line,
             curve == Curve::flux ? "relative_photon_flux"
             : curve == Curve::qe ? "qe"
                                  : "throughput");
    const Place at = {path, line};
    SpectrumColumns columns;
    columns.nm = nm_of(wavelength, at);
    if (curve == Curve::flux)
        columns.photons_power = photons_power_of(value, at);
    else
        check_fraction(value, curve, at);
    return columns;
}

} // namespace toliman
