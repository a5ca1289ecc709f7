// The header of a text table: which of its lines are no rows, the names, units and places of its columns, and the
// fields of its rows.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/byte_columns.hpp"

namespace toliman::ingest {

class TableHeader {
  public:
    enum class Line {
        skipped, // of the header, or empty of values
        names,   // the columns are known now
        row
    };

    // What a line is, which is neither empty nor a comment. Status::format for a line that begins a second table.
    Line take(std::string_view line);
    // A comment, from its #. Status::format if it begins a second table.
    void comment(std::string_view line);

    // The fields of a row. Until begin_rows(), each row determines the separator again, unless names did.
    std::vector<std::string> fields(std::string_view row);
    // The columns of a table without a line of names: those of a comment, if it names as many and is_useful(names),
    // otherwise columns without names.
    template <class Test> void name_by_comments(size_t width, Test is_useful);
    // The layout is final: the first row was accepted.
    void begin_rows() noexcept { rows_ = true; }

    const std::vector<TableColumn> &columns() const noexcept { return columns_; }
    std::vector<std::string> names() const;
    bool is_fixed() const noexcept { return bytes_.is_used(); } // columns are ranges of bytes
    char separator() const noexcept { return separator_; }

  private:
    Line take_bars(std::string_view line);
    bool is_extension(std::string_view line);
    bool set_units(const std::vector<std::string> &fields);
    void set_width(size_t width);
    void set_names(const std::vector<std::string> &names);
    std::vector<std::vector<std::string>> readings(const std::string &comment, size_t width) const;

    std::vector<TableColumn> columns_;
    ByteColumns bytes_;
    std::vector<std::string> comments_; // the last ones before the rows
    std::string ecsv_;                  // the part of the header that describes columns
    bool is_ecsv_ = false, is_ipac_ = false, named_ = false, rows_ = false;
    int bar_lines_ = 0; // with types, units and null values, below the names
    char separator_ = ',';
};

template <class Test> void TableHeader::name_by_comments(size_t width, Test is_useful) {
    set_width(width);
    for (size_t i = comments_.size(); i-- > 0;)
        for (const std::vector<std::string> &names : readings(comments_[i], width)) {
            if (!is_useful(names))
                continue;
            set_names(names);
            for (size_t k = i + 1; k < comments_.size(); k++)
                for (const std::vector<std::string> &units : readings(comments_[k], width))
                    if (set_units(units))
                        break;
            return;
        }
}

} // namespace toliman::ingest
