// The instruments of a series: those of the column that the caller names, or the column that seems to have them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace toliman::ingest {

class Instruments {
  public:
    // The index of a name, in order of first appearance. Status::format if there are too many.
    int64_t index_of(const std::string &name);
    const std::vector<std::string> &names() const noexcept { return names_; }

  private:
    std::vector<std::string> names_;
};

// Finds the column of few distinct texts, or of an instrument's name, that was not named.
class LikelyInstrument {
  public:
    static constexpr size_t kMostColumns = 64; // that are examined

    // name: of the column, or its number. Further texts of a column that cannot be one are ignored.
    void add(const std::string &name, const std::string &text);
    std::string name() const; // of a column with at least two distinct texts; "" if there is none

  private:
    struct Column {
        std::string name;
        bool is_named, possible;
        int64_t rows;
        std::set<std::string> texts;
    };
    std::vector<Column> columns_;
    size_t next_ = 0; // the columns of a row come in the same order
};

} // namespace toliman::ingest
