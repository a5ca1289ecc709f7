// Series in CSV: comments with #, a line of names or none.
#pragma once
#include <string>
#include <vector>

namespace cli {

struct Series {
    std::string name;                // as messages call the file
    std::vector<double> t, y, sigma; // sigma empty when the file has none
};

// Columns are t,y or t,y,sigma. With a line of names they stand anywhere among others, and `columns` may be other names
// for them: {"t", "latent"}. Every malformed line is an error that names file, line, column and what is allowed.
Series read_series(const std::string &name, const std::vector<std::string> &columns = {});

// The names in "t,latent".
std::vector<std::string> names_of(const std::string &list);

} // namespace cli
