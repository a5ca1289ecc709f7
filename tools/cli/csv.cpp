#include "csv.hpp"

#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>

#include "failure.hpp"

namespace cli {

namespace {

std::vector<std::string> fields_of(const std::string &line) {
    std::vector<std::string> fields(1);
    for (char c : line)
        if (c == ',')
            fields.emplace_back();
        else if (!std::isspace(static_cast<unsigned char>(c)))
            fields.back() += c;
    return fields;
}

bool number_of(const std::string &field, double &value) {
    char *end = nullptr;
    value = std::strtod(field.c_str(), &end);
    return !field.empty() && *end == '\0';
}

[[noreturn]] void malformed(const std::string &path, size_t line, const std::string &why) {
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
        if (first && fields.size() >= 2 && !number_of(fields[0], values[0]) && !number_of(fields[1], values[1])) {
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
