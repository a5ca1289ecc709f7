// Splits lines of text into columns.
#pragma once
#include <string>
#include <vector>

namespace cli {

enum class Separator { semicolon, comma, space };

// The separator of a file's columns, from its first line that is neither empty nor a comment: semicolons if the line
// has one, otherwise commas if it has one, otherwise white space (any number of blanks and tabs).
Separator separator_of(const std::string &line);
// "semicolons"
const char *name_of(Separator separator) noexcept;

// Without surrounding white space, and then without surrounding quotes. White space inside remains.
std::string trimmed(const std::string &text);
// The fields of a line, trimmed; at least one.
std::vector<std::string> split(const std::string &line, Separator separator);
// The names in "t,latent".
std::vector<std::string> names_of(const std::string &list);
// The inverse of names_of.
std::string joined(const std::vector<std::string> &names);

// Whether the whole field, with any NUL byte in it, is a number.
bool number_of(const std::string &field, double &value);
// Whether the field is a number with a decimal comma.
bool decimal_comma(const std::string &field);

} // namespace cli
