// Formats text and numbers.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace cli {

// printf into a string.
__attribute__((format(printf, 1, 2))) std::string formatted(const char *format, ...);

bool ends_with(const std::string &path, const std::string &suffix);
std::string joined(const std::vector<std::string> &words, const char *between = ", ");

// Whether the whole text, with any NUL byte in it, is a number.
bool number_of(const std::string &text, double &value);
// "256x128"
template <class Integer> std::string shape_text(Integer rows, Integer cols) {
    return std::to_string(rows) + "x" + std::to_string(cols);
}

// Whether the text is two whole numbers with this separator: "0:100", "16,24", "256x128".
bool two_numbers(const std::string &text, char separator, int64_t &first, int64_t &second);

// "0123456789abcdef" of a 64-bit hash.
std::string digest_text(uint64_t digest);

// Bytes in B, kB, MB, GB or TB (powers of 1000) with three digits: "524 kB", "10.5 TB".
std::string size_text(double bytes);

// Decimals of a value with standard error `error`: those of two digits of the error, as in 2.59931 +- 0.00042; 2 if the
// error is unknown.
int decimals_of(double error);

// A value and a limit on different sides of which it is printed: with `digits` digits, or as many as distinguish them.
struct Apart {
    std::string value, limit;
};
Apart apart(double value, double limit, int digits);

// "363.1 +- 3.1", "3.012e-07 +- 4.0e-09". The value has six digits if the error is 0, infinite or NaN; a NaN error is
// left out.
std::string text_with_error(double value, double error);

} // namespace cli
