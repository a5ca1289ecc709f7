// Columns at fixed bytes: of the byte-by-byte descriptions of VizieR, CDS and the AAS, or between the bars of IPAC.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace toliman::ingest {

constexpr int kTextColumn = -2;

struct TableColumn {
    std::string name, unit;     // "" if they are not stated
    std::string null;           // text of a missing value; "" for the usual ones only
    size_t first = 0, last = 0; // bytes, from 1; 0 for a column that is separated from others
    int decimals = -1;          // places after the point; -1: not known; kTextColumn
    bool optional = false;      // may be blank at the end of a row
};

class ByteColumns {
  public:
    // Whether a line belongs to a byte-by-byte description or to its notes. Status::format for a second description.
    bool take(std::string_view line);
    bool is_used() const noexcept { return state_ != State::none; }
    bool is_described() const noexcept { return state_ == State::notes || state_ == State::rows; }
    std::vector<TableColumn> &columns() noexcept { return columns_; }

  private:
    enum class State { none, title, heading, columns, notes, rows };
    void add_column(std::string_view line);

    State state_ = State::none;
    std::vector<TableColumn> columns_;
};

// The fields of a row at the bytes of its columns. Status::format if there is text between them, or if the row ends
// within or before one that must not be blank.
std::vector<std::string> fields_at(std::string_view row, const std::vector<TableColumn> &columns);

// Whether a line consists of signs that separate parts of a table: ---- ==== +--+--+ with blanks.
bool is_rule(std::string_view line) noexcept;

} // namespace toliman::ingest
