// Splits lines of text into columns.
#pragma once
#include <string>
#include <vector>

namespace cli {

// The separator of a file's columns, from its first line that is neither empty nor a comment: a semicolon if the line
// has one, otherwise a comma if it has one, otherwise a blank for white space (any number of blanks and tabs).
char separator_of(const std::string &line);
const char *separator_name(char separator) noexcept; // "semicolons"

// Without surrounding white space, and then without surrounding quotes. White space inside remains.
std::string trimmed(const std::string &text);
// The fields of a line, trimmed; at least one.
std::vector<std::string> split(const std::string &line, char separator);

// Whether the whole field, with any NUL byte in it, is a number.
bool number_of(const std::string &field, double &value);
// Whether the field is a number with a decimal comma.
bool decimal_comma(const std::string &field);

} // namespace cli
