// Numbers and names as text: for people, for HTML and for gnuplot.
#pragma once
#include <string>
#include <vector>

namespace cli {

std::string printed(const char *format, ...) __attribute__((format(printf, 1, 2)));

// Numbers in HTML; a dash for what is none.
std::string fixed(double value, int decimals);         // 363.11
std::string exponential(double value, int digits = 3); // 1.24 x 10^-6, 1.00 x 10^-2
std::string scientific(double value, int digits = 3);  // the same of what is small or large, else 0.01
std::string with_error(double value, double error, int least_decimals = 2); // 363.11 +- 3.13, see decimals_of

// A unit of a power of 1000, in which the largest of the numbers has up to three digits before its point.
struct ShortUnit {
    double factor; // numbers times it are in the unit
    std::string name;
};
ShortUnit short_unit(const std::vector<double> &numbers, const std::string &unit);

// Text between tags and in attributes of HTML.
std::string escaped(const std::string &text);
std::string base64(const std::string &bytes);
// A string of gnuplot's, which does not look into it; control bytes become blanks.
std::string gnuplot_text(const std::string &text);

} // namespace cli
