// Series in CSV: t,y[,sigma], comments with #, an optional header line.
#pragma once
#include <string>
#include <vector>

namespace cli {

struct Series {
    std::vector<double> t, y, sigma; // sigma empty when the file has two columns
};

// Every malformed line is an error that names file, line, column and what is allowed.
Series read_series(const std::string &name);

} // namespace cli
