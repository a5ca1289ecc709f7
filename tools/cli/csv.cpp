#include "csv.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>

#include "failure.hpp"

namespace cli {

namespace {

// Without the white space around it; what is inside stays and makes no number.
std::string trimmed(const std::string &text) {
    constexpr char space[] = " \t\r\v\f";
    const size_t first = text.find_first_not_of(space);
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(space) - first + 1);
}

std::vector<std::string> fields_of(const std::string &line) {
    std::vector<std::string> fields;
    size_t start = 0;
    for (size_t comma; (comma = line.find(',', start)) != std::string::npos; start = comma + 1)
        fields.push_back(trimmed(line.substr(start, comma - start)));
    fields.push_back(trimmed(line.substr(start)));
    return fields;
}

// All of the field is a number, NUL bytes included.
bool number_of(const std::string &field, double &value) {
    char *end = nullptr;
    value = std::strtod(field.c_str(), &end);
    return !field.empty() && end == field.c_str() + field.size();
}

// A name of a column, not a damaged number.
bool heading(const std::string &field) {
    double number;
    return field.empty() || (std::strchr("0123456789+-.", field[0]) == nullptr && !number_of(field, number));
}

// `why` may quote the file: what does not print becomes ?.
[[noreturn]] void malformed(const std::string &path, size_t line, std::string why) {
    std::replace_if(
        why.begin(), why.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, '?');
    throw Failure(kExitInput, path + ":" + std::to_string(line) + ": " + why);
}

} // namespace

Series read_series(const std::string &name) {
    const bool piped = name == "-";
    const std::string path = piped ? "standard input" : name;
    std::ifstream file;
    if (!piped)
        file.open(path);
    if (!file)
        throw Failure(kExitInput, path + ": " + std::strerror(errno));
    std::istream &in = piped ? std::cin : file;
    constexpr const char *names[] = {"t", "y", "sigma"};
    Series series;
    std::string line;
    size_t columns = 0;
    for (size_t number = 1; std::getline(in, line); number++) {
        const std::vector<std::string> fields = fields_of(line);
        if (fields[0].empty() && fields.size() == 1)
            continue;
        if (fields[0][0] == '#')
            continue;
        double values[3] = {0, 0, 1};
        const bool first = columns == 0 && series.t.empty();
        if (first && fields.size() >= 2 && heading(fields[0]) && heading(fields[1])) {
            columns = fields.size(); // header line
            if (columns > 3)
                malformed(path, number, "has " + std::to_string(columns) + " columns: t,y or t,y,sigma are read");
            continue;
        }
        if (columns == 0)
            columns = fields.size();
        if (columns < 2 || columns > 3 || fields.size() != columns)
            malformed(path, number,
                      "has " + std::to_string(fields.size()) + " columns: " +
                          (columns == 2   ? "t,y as in the lines before"
                           : columns == 3 ? "t,y,sigma as in the lines before"
                                          : "t,y or t,y,sigma are read"));
        for (size_t i = 0; i < columns; i++)
            if (!number_of(fields[i], values[i]) || !std::isfinite(values[i]))
                malformed(path, number, std::string(names[i]) + " = \"" + fields[i] + "\": must be a finite number");
        if (columns == 3 && values[2] <= 0)
            malformed(path, number, "sigma = " + fields[2] + ": must be above 0");
        series.t.push_back(values[0]);
        series.y.push_back(values[1]);
        if (columns == 3)
            series.sigma.push_back(values[2]);
    }
    if (in.bad())
        throw Failure(kExitInput, path + ": cannot be read");
    if (series.t.empty())
        throw Failure(kExitInput, path + ": holds no samples");
    return series;
}

} // namespace cli
