// Numbers that stand for missing values: -9999, 99.99, 1e30, far outside of the other values of a column.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace toliman::ingest {

class MissingMarks {
  public:
    // column: 0 t, 1 y, 2 sigma.
    void add(size_t column, double value, int64_t line);
    // "y = -9999 on lines 6, 15, 24"; "" if no value is such a mark among those added so far. what: the word for a
    // line; before: the number of lines before the first one that is counted.
    std::string found(const std::string &what = "line", int64_t before = 0) const;

  private:
    struct Mark {
        double value;
        int64_t count;
        std::vector<int64_t> lines; // the first ones
    };
    struct Column {
        double least = 0, largest = 0; // of the values that cannot be marks
        int64_t count = 0;
        std::vector<Mark> marks;
    };
    std::array<Column, 3> columns_;
};

} // namespace toliman::ingest
