// Fields of the lines of text tables: how a line is split, numbers, words for missing values.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace toliman::ingest {

constexpr char kSpace[] = " \t\r\v\f"; // white space within a line

// Separators are ';', ',', '\t', '|', and ' ' for white space of any length.
const char *separator_name(char separator) noexcept;
// Of a line of values, or of names: a semicolon, a bar, a tab, a comma, otherwise white space. Those within quotes or
// brackets do not count.
char separator_of(std::string_view line);

// Without surrounding white space, and then without surrounding quotes. White space inside remains.
std::string trimmed(std::string_view text);

// The fields of a line, trimmed; at least one. A separator within quotes does not separate, and neither does the blank
// between a date and its time.
std::vector<std::string> split(std::string_view line, char separator);
// The same of a line of names: a separator within brackets does not separate, and brackets after a blank belong to the
// name before.
std::vector<std::string> split_names(std::string_view line, char separator);

// Without the comment that follows a # at the beginning or after a blank, outside of quotes.
std::string_view without_remark(std::string_view line) noexcept;
// With the separator in place of "+-", "+/-" and the sign plus-minus between two numbers.
std::string without_plus_minus(std::string_view line, char separator);

// Whether the whole text, with any zero byte in it, is a number as strtod or Fortran (exponent d) reads it, decimal or
// hexadecimal; with a decimal point in every locale. Numbers beyond the range of double become 0 or infinite.
bool number_of(const std::string &text, double &value) noexcept;
// "1.5" of "1,5"; "" if the text is not a number with a decimal comma.
std::string with_decimal_point(const std::string &text);

// Whether a text stands for a missing value: empty, nan, -, --, ..., null, n/a, masked and others.
bool is_missing(std::string_view text);
// Whether a field is a column name, not a damaged number.
bool is_column_name(const std::string &field);

std::string lower(std::string_view text);
// With ? for each byte that is not ASCII, of an encoding that is not known.
std::string in_ascii(std::string text);
std::string joined(const std::vector<std::string> &words);

} // namespace toliman::ingest
