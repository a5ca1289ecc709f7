// A wavelength without a unit is in nm only if it can be: a spectrum in angstrom or um, read as nm, would be far
// ultraviolet or infrared light, and silently another spectrum.
#include "scene/spectrum_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "backend/file.hpp"
#include "base/error.hpp"

namespace toliman {

namespace {

constexpr size_t kLargestFile = 16 << 20;
constexpr double kShortestNm = 100, kLongestNm = 3000; // of wavelengths without a unit
constexpr const char *kNames[] = {"flux", "throughput", "qe", "response"};

const char *skip_spaces(const char *text, const char *end) {
    while (text != end && (*text == ' ' || *text == '\t' || *text == '\r'))
        text++;
    return text;
}

// Reads two numbers separated by a comma or blanks; false if the text is anything else.
bool read_pair(const char *text, const char *end, double &first, double &second) {
    const auto [after_first, error] = std::from_chars(text, end, first);
    const char *next = skip_spaces(after_first, end);
    if (error != std::errc() || next == end || (*next != ',' && next == after_first))
        return false;
    next = skip_spaces(*next == ',' ? next + 1 : next, end);
    const auto [after_second, second_error] = std::from_chars(next, end, second);
    return second_error == std::errc() && skip_spaces(after_second, end) == end;
}

// The comments of a table, which may have what a header has.
class Comments {
  public:
    void add(const std::string &text, size_t line) {
        last_ = text, line_ = line;
        const std::string name = field(text, "name:"), unit = field(text, "unit:"); // of ECSV
        if (!name.empty() && !unit.empty())
            std::replace_copy(unit.begin(), unit.end(), std::back_inserter(units_[name]), ' ', '.');
    }
    // The header with the units of its columns.
    std::string with_units(const std::string &header) const {
        const std::string blanks = " \t\r,";
        std::string text;
        for (size_t start = 0, stop; start < header.size(); start = stop) {
            const size_t name = std::min(header.find_first_not_of(blanks, start), header.size());
            stop = std::min(header.find_first_of(blanks, name), header.size());
            text += header.substr(start, stop - start);
            if (const auto unit = units_.find(header.substr(name, stop - name)); unit != units_.end())
                text += "(" + unit->second + ")";
        }
        return text;
    }
    // The last comment as a header, if it is in `line` and reads as one.
    std::optional<SpectrumColumns> as_header(Curve curve, const std::string &path, size_t line) const {
        if (line_ == 0 || line_ != line)
            return std::nullopt;
        try {
            return spectrum_columns(last_, curve, path, line);
        } catch (const Error &) { // an ordinary comment
            return std::nullopt;
        }
    }

  private:
    // The value of `key` in a line such as {name: wavelength, unit: Angstrom}.
    static std::string field(const std::string &text, const char *key) {
        const size_t at = text.find(key);
        if (text.find('{') == std::string::npos || at == std::string::npos)
            return "";
        const size_t start = std::min(text.find_first_not_of(' ', text.find(':', at) + 1), text.size());
        return text.substr(start, std::min(text.find_first_of(",}", start), text.size()) - start);
    }

    std::string last_;
    size_t line_ = 0; // of the last comment; 0: none
    std::map<std::string, std::string> units_;
};

// The wavelength in nm.
double nm_of(double wavelength, const SpectrumColumns &columns, const std::string &path, size_t line, Curve curve) {
    if (columns.nm == 0 && !(wavelength >= kShortestNm && wavelength <= kLongestNm))
        fail(Status::format,
             "{%s}: line %zu: wavelength = %g: must be in [%g, %g] nm, or in a unit that the header names, such as "
             "wavelength_angstrom,%s",
             path.c_str(), line, wavelength, kShortestNm, kLongestNm, kNames[static_cast<size_t>(curve)]);
    return wavelength * (columns.nm != 0 ? columns.nm : 1);
}

// Whether a wavelength may follow the others, which all increase or all decrease.
bool follows(const std::vector<double> &others, double nm) noexcept {
    if (!std::isfinite(nm) || !(nm > 0))
        return false;
    if (others.size() < 2)
        return others.empty() || nm != others.back();
    return others[1] > others[0] ? nm > others.back() : nm < others.back();
}

void check_value(const std::string &path, size_t line, Curve curve, double value) {
    const bool fraction = curve == Curve::throughput || curve == Curve::qe;
    const char *const name = kNames[static_cast<size_t>(curve)];
    if (!(value >= 0) || !std::isfinite(value))
        fail(Status::format, "{%s}: line %zu: %s = %g: must be finite and not negative", path.c_str(), line, name,
             value);
    if (fraction && value > 1)
        fail(Status::format, "{%s}: line %zu: %s = %g: must be in [0, 1]%s", path.c_str(), line, name, value,
             value <= 100 ? ", not in percent" : "");
}

} // namespace

SpectrumTable::SpectrumTable(const std::string &path, Curve curve) {
    const std::vector<uint8_t> bytes = file::read(path, kLargestFile);
    const char *text = reinterpret_cast<const char *>(bytes.data()), *end = text + bytes.size();
    Comments comments;
    std::optional<SpectrumColumns> columns;
    for (size_t line = 1; text != end; line++) {
        const char *stop = std::find(text, end, '\n'), *start = skip_spaces(text, stop);
        text = stop == end ? end : stop + 1;
        if (start == stop)
            continue;
        if (*start == '#') {
            comments.add(std::string(skip_spaces(start + 1, stop), stop), line);
            continue;
        }
        double wavelength, value;
        if (!read_pair(start, stop, wavelength, value)) {
            if (columns || (*start >= '0' && *start <= '9'))
                fail(Status::format, "{%s}: line %zu: must be two numbers, separated by a comma or blanks",
                     path.c_str(), line);
            columns = spectrum_columns(comments.with_units(std::string(start, stop)), curve, path, line);
            continue;
        }
        if (!columns)
            columns = comments.as_header(curve, path, line - 1).value_or(SpectrumColumns());
        wavelength = nm_of(wavelength, *columns, path, line, curve);
        if (!follows(wavelength_nm_, wavelength))
            fail(Status::format, "{%s}: line %zu: wavelengths must increase, or decrease", path.c_str(), line);
        value *= std::pow(wavelength, columns->photons_power);
        check_value(path, line, curve, value);
        wavelength_nm_.push_back(wavelength);
        value_.push_back(value);
    }
    if (wavelength_nm_.empty())
        fail(Status::format, "{%s}: contains no numbers", path.c_str());
    if (wavelength_nm_.front() > wavelength_nm_.back()) {
        std::reverse(wavelength_nm_.begin(), wavelength_nm_.end());
        std::reverse(value_.begin(), value_.end());
    }
}

bool SpectrumTable::covers(double least_nm, double most_nm) const noexcept {
    constexpr double kRounding = 1e-12;
    return first_nm() <= least_nm * (1 + kRounding) && last_nm() >= most_nm * (1 - kRounding);
}

double SpectrumTable::at(double wavelength_nm) const noexcept {
    wavelength_nm = std::clamp(wavelength_nm, first_nm(), last_nm());
    const auto above = std::lower_bound(wavelength_nm_.begin(), wavelength_nm_.end(), wavelength_nm);
    const auto i = static_cast<size_t>(above - wavelength_nm_.begin());
    if (*above == wavelength_nm)
        return value_[i];
    const double share = (wavelength_nm - wavelength_nm_[i - 1]) / (wavelength_nm_[i] - wavelength_nm_[i - 1]);
    return value_[i - 1] + share * (value_[i] - value_[i - 1]);
}

} // namespace toliman
