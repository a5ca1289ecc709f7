#include "scene/spectrum_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "backend/file.hpp"
#include "base/error.hpp"
#include "scene/spectrum_columns.hpp"

namespace toliman {

namespace {

constexpr size_t kLargestFile = 16 << 20;

const char *skip_spaces(const char *text, const char *end) {
    while (text != end && (*text == ' ' || *text == '\t' || *text == '\r'))
        text++;
    return text;
}

// Reads two numbers separated by a comma; false if the text is anything else.
bool read_pair(const char *text, const char *end, double &first, double &second) {
    const auto [after_first, error] = std::from_chars(skip_spaces(text, end), end, first);
    const char *comma = skip_spaces(after_first, end);
    if (error != std::errc() || comma == end || *comma != ',')
        return false;
    const auto [after_second, second_error] = std::from_chars(skip_spaces(comma + 1, end), end, second);
    return second_error == std::errc() && skip_spaces(after_second, end) == end;
}

} // namespace

SpectrumTable::SpectrumTable(const std::string &path) {
    const std::vector<uint8_t> bytes = file::read(path, kLargestFile);
    const char *text = reinterpret_cast<const char *>(bytes.data()), *end = text + bytes.size();
    bool header_allowed = true;
    SpectrumColumns columns;
    for (size_t number = 1; text != end; number++) {
        const char *stop = std::find(text, end, '\n'), *start = skip_spaces(text, stop);
        text = stop == end ? end : stop + 1;
        if (start == stop || *start == '#')
            continue;
        double wavelength, flux;
        if (!read_pair(start, stop, wavelength, flux)) {
            if (!std::exchange(header_allowed, false) || (*start >= '0' && *start <= '9'))
                fail(Status::format, "{%s}: line %zu: must be two numbers separated by a comma", path.c_str(), number);
            columns = spectrum_columns(std::string(start, stop), path, number);
            continue;
        }
        wavelength *= columns.nm;
        header_allowed = false;
        if (!std::isfinite(wavelength) || (!wavelength_nm_.empty() && wavelength <= wavelength_nm_.back()))
            fail(Status::format, "{%s}: line %zu: wavelengths must increase", path.c_str(), number);
        if (!(flux >= 0) || !std::isfinite(flux))
            fail(Status::format, "{%s}: line %zu: flux = %g: must be finite and not negative", path.c_str(), number,
                 flux);
        wavelength_nm_.push_back(wavelength);
        flux_.push_back(flux * std::pow(wavelength, columns.photons_power));
    }
    if (wavelength_nm_.empty())
        fail(Status::format, "{%s}: contains no numbers", path.c_str());
}

double SpectrumTable::at(double wavelength_nm) const noexcept {
    wavelength_nm = std::clamp(wavelength_nm, first_nm(), last_nm());
    const auto above = std::lower_bound(wavelength_nm_.begin(), wavelength_nm_.end(), wavelength_nm);
    const auto i = static_cast<size_t>(above - wavelength_nm_.begin());
    if (*above == wavelength_nm)
        return flux_[i];
    const double share = (wavelength_nm - wavelength_nm_[i - 1]) / (wavelength_nm_[i] - wavelength_nm_[i - 1]);
    return flux_[i - 1] + share * (flux_[i] - flux_[i - 1]);
}

} // namespace toliman
