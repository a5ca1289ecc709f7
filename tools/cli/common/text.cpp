#include "common/text.hpp"

#include <cinttypes>
#include <cstdarg>
#include <cstdlib>

#include "common/common.hpp"

namespace cli {

std::string formatted(const char *format, ...) {
    std::va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    std::string text(static_cast<size_t>(std::vsnprintf(nullptr, 0, format, arguments)), '\0');
    std::vsnprintf(text.data(), text.size() + 1, format, again);
    va_end(again);
    va_end(arguments);
    return text;
}

bool ends_with(const std::string &path, const std::string &suffix) {
    return path.size() >= suffix.size() && path.compare(path.size() - suffix.size(), suffix.size(), suffix) == 0;
}

std::string joined(const std::vector<std::string> &words, const char *between) {
    std::string text;
    for (const std::string &word : words)
        text += (text.empty() ? "" : between) + word;
    return text;
}

bool number_of(const std::string &text, double &value) {
    char *end = nullptr;
    value = std::strtod(text.c_str(), &end);
    return !text.empty() && end == text.c_str() + text.size();
}

bool two_numbers(const std::string &text, char separator, int64_t &first, int64_t &second) {
    char between = '\0', rest = '\0';
    return std::sscanf(text.c_str(), "%" SCNd64 "%c%" SCNd64 "%c", &first, &between, &second, &rest) == 3 &&
           between == separator;
}

std::string digest_text(uint64_t digest) {
    return formatted("%016llx", static_cast<unsigned long long>(digest));
}

std::string size_text(double bytes) {
    const char *const units[] = {"B", "kB", "MB", "GB", "TB"};
    size_t unit = 0;
    for (; unit < 4 && bytes >= 999.5; unit++)
        bytes /= 1000;
    return formatted("%.*f %s", unit == 0 || bytes >= 99.95 ? 0 : bytes >= 9.995 ? 1 : 2, bytes, units[unit]);
}

namespace {

// Decimal exponent of a finite number after rounding to two digits.
int exponent_of(double value) {
    const std::string text = formatted("%.1e", value);
    return std::atoi(text.c_str() + text.find('e') + 1);
}

} // namespace

int decimals_of(double error) {
    return std::isfinite(error) && error > 0 ? std::clamp(1 - exponent_of(error), 0, 15) : 2;
}

Apart apart(double value, double limit, int digits) {
    constexpr int kExact = 17;
    Apart made = {formatted("%.*g", digits, value), formatted("%.*g", digits, limit)};
    return made.value != made.limit || value == limit || digits >= kExact ? made : apart(value, limit, digits + 1);
}

std::string text_with_error(double value, double error) {
    constexpr int plain = 5, most = 15; // decimal exponents below -plain or above `most` are printed as such
    if (std::isnan(error) || !std::isfinite(value))
        return formatted("%.6g", value);
    if (!std::isfinite(error) || error <= 0)
        return formatted("%.6g +- %.2g", value, error);
    const int first = exponent_of(std::max(std::fabs(value), error));
    if (first < -plain || first > most)
        return formatted("%.*e +- %.1e", std::clamp(exponent_of(value) - exponent_of(error) + 1, 0, most), value,
                         error);
    return formatted("%.*f +- %.*f", decimals_of(error), value, decimals_of(error), error);
}

} // namespace cli
