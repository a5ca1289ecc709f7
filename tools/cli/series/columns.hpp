// Columns of a line of text.
#pragma once
#include <string>
#include <vector>

namespace cli {

enum class Separator { semicolon, comma, space };

// What separates the columns of a file, by its first line that is not empty and no comment: semicolons if it has one,
// else commas if it has one, else white space (any number of blanks and tabs).
Separator separator_of(const std::string &line);
// "semicolons"
const char *name_of(Separator separator) noexcept;

// Without the white space around it and the quotes around that; what is inside stays and makes no number.
std::string trimmed(const std::string &text);
// The fields of a line, trimmed; at least one.
std::vector<std::string> split(const std::string &line, Separator separator);
// The names in "t,latent".
std::vector<std::string> names_of(const std::string &list);
// And back.
std::string joined(const std::vector<std::string> &names);

// All of the field is a number, NUL bytes included.
bool number_of(const std::string &field, double &value);
// With a comma for the decimal point.
bool decimal_comma(const std::string &field);

} // namespace cli
