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

constexpr size_t kFewest = 2, kMost = 3; // columns that are read
constexpr const char *kNames[kMost] = {"t", "y", "sigma"};
constexpr double kLargest = 1e98, kLeastSigma = 1e-98; // squares and differences of these keep within double

// Without the white space around it and the quotes around that; what is inside stays and makes no number.
std::string trimmed(const std::string &text) {
    constexpr char space[] = " \t\r\v\f";
    const size_t first = text.find_first_not_of(space);
    if (first == std::string::npos)
        return "";
    const std::string word = text.substr(first, text.find_last_not_of(space) - first + 1);
    const bool quoted = word.size() >= 2 && word.front() == '"' && word.back() == '"';
    return quoted ? word.substr(1, word.size() - 2) : word;
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

std::string joined(const std::vector<std::string> &names) {
    std::string list;
    for (const std::string &name : names)
        list += (list.empty() ? "" : ",") + name;
    return list;
}

// Reads the lines of one file.
class SeriesReader {
  public:
    SeriesReader(const std::string &name, const std::vector<std::string> &columns) : wanted_(columns) {
        series_.name = name;
    }

    Series read(std::istream &in) {
        for (std::string line; std::getline(in, line);) {
            number_++;
            if (number_ == 1)
                begin(line);
            const std::vector<std::string> fields = names_of(line);
            const bool empty = fields.size() == 1 && fields[0].empty();
            if (!empty && fields[0][0] != '#')
                take(fields);
        }
        if (in.bad())
            cli::malformed(series_.name, "cannot be read");
        if (series_.t.empty())
            cli::malformed(series_.name, number_ == 0 ? "is empty" : "holds no samples");
        return std::move(series_);
    }

  private:
    // `why` may quote the file: what does not print becomes ?.
    [[noreturn]] void malformed(std::string why) const {
        std::replace_if(
            why.begin(), why.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, '?');
        cli::malformed(series_.name + ":" + std::to_string(number_), why);
    }

    // Editors of some systems put a mark before the text, U+FEFF.
    void begin(std::string &line) const {
        if (line.compare(0, 6, "\x93NUMPY") == 0)
            cli::malformed(series_.name, "is a .npy file: a series is CSV");
        if (line.compare(0, 3, "\xef\xbb\xbf") == 0)
            line.erase(0, 3);
    }

    void take(const std::vector<std::string> &fields) {
        if (width_ == 0 && fields.size() >= kFewest && heading(fields[0]) && heading(fields[1]))
            return take_names(fields);
        if (width_ == 0)
            take_positions(fields.size());
        if (fields.size() != width_)
            malformed("has " + std::to_string(fields.size()) + " columns: the lines before have " +
                      std::to_string(width_));
        double values[kMost] = {0, 0, 1};
        for (size_t i = 0; i < at_.size(); i++)
            values[i] = value_of(fields[at_[i]], i);
        series_.t.push_back(values[0]);
        series_.y.push_back(values[1]);
        if (at_.size() == kMost)
            series_.sigma.push_back(values[2]);
    }

    void take_names(const std::vector<std::string> &fields) {
        const std::vector<std::string> names =
            wanted_.empty() ? std::vector<std::string>(kNames, kNames + kMost) : wanted_;
        for (const std::string &name : names) {
            const auto at = std::find(fields.begin(), fields.end(), name);
            if (at != fields.end())
                at_.push_back(static_cast<size_t>(at - fields.begin()));
            else if (!wanted_.empty() || at_.size() < kFewest)
                malformed("has no column " + name + " among " + joined(fields) +
                          ": --columns T,Y or T,Y,SIGMA names them");
        }
        width_ = fields.size();
    }

    void take_positions(size_t columns) {
        if (!wanted_.empty())
            malformed("names no columns: --columns " + joined(wanted_) + " needs a first line that does");
        if (columns < kFewest || columns > kMost)
            malformed("has " + std::to_string(columns) + " columns: without a line of names t,y or t,y,sigma are read");
        for (size_t i = 0; i < columns; i++)
            at_.push_back(i);
        width_ = columns;
    }

    double value_of(const std::string &field, size_t column) const {
        const std::string shown = kNames[column] + (" = \"" + field + "\": ");
        double value;
        if (!number_of(field, value) || !std::isfinite(value))
            malformed(shown + "must be a finite number");
        if (column == 2 && !(value >= kLeastSigma && value <= kLargest))
            malformed(shown + "must be above 0, from 1e-98 to 1e98");
        if (std::fabs(value) > kLargest)
            malformed(shown + "must be within -1e98 to 1e98");
        return value;
    }

    std::vector<std::string> wanted_;
    std::vector<size_t> at_; // places of t, y and sigma in a line
    size_t width_ = 0;       // fields of every line, 0 before the first
    size_t number_ = 0;      // of the line
    Series series_;
};

} // namespace

std::vector<std::string> names_of(const std::string &list) {
    std::vector<std::string> names;
    size_t start = 0;
    for (size_t comma; (comma = list.find(',', start)) != std::string::npos; start = comma + 1)
        names.push_back(trimmed(list.substr(start, comma - start)));
    names.push_back(trimmed(list.substr(start)));
    return names;
}

Series read_series(const std::string &name, const std::vector<std::string> &columns) {
    if (name == "-")
        return SeriesReader("standard input", columns).read(std::cin);
    std::ifstream file(name);
    if (!file)
        malformed(name, std::strerror(errno));
    return SeriesReader(name, columns).read(file);
}

} // namespace cli
