// Parses the lines of a time series to samples.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "backend/json.hpp"
#include "ingest/column_names.hpp"
#include "ingest/instrument_column.hpp"
#include "ingest/missing_marks.hpp"
#include "ingest/series_times.hpp"
#include "ingest/table_header.hpp"
#include "ingest/unit.hpp"

namespace toliman::ingest {

struct SeriesOptions {
    std::string name;                 // of the input, for messages; may be empty
    std::vector<std::string> columns; // names or numbers of t, y and perhaps sigma; empty: the usual names
    std::string instrument;           // name or number of the column; empty: none
    bool growing = false;             // as in series.h
    TimeOptions times;
};

struct Sample {
    double t, y, sigma; // sigma is 0 if the series has none
    int64_t instrument; // index into Series::instruments(); -1 without such a column
};

class Series {
  public:
    explicit Series(SeriesOptions options) : options_(std::move(options)), times_(options_.times) {}

    // Empty for comments, empty lines, the lines of a header and rows without a value. Status::format: the line is
    // malformed, later ones may be samples. Status::mismatch: the input has no such columns. Other errors change
    // nothing.
    std::optional<Sample> parse(std::string_view line);
    // The next warnings, each once; they begin with the name of the input.
    std::vector<std::string> take_warnings();

    int64_t lines() const noexcept { return lines_; }
    int64_t missing() const noexcept { return missing_; } // rows that have no t, y or sigma
    bool truncated() const noexcept { return truncated_; }
    const Unit &unit() const noexcept { return unit_; } // of y
    double time_unit_days() const noexcept { return times_.unit_days(); }
    std::optional<TimeFormat> format() const noexcept { return times_.format(); } // empty for plain numbers
    Scale scale() const noexcept { return times_.scale(); }
    const std::vector<std::string> &instruments() const noexcept { return instruments_.names(); }
    // The column that seems to have instruments, if it was not named; "" if there is none.
    std::string likely_instrument() const { return likely_.name(); }
    const MissingMarks &marks() const noexcept { return marks_; }

  private:
    std::optional<Sample> parse_line(std::string_view line);
    std::optional<Sample> parse_row(std::string_view line);
    std::optional<Sample> parse_object(const std::string &line);
    Sample sample_of(double t, double y, double sigma, const std::string *instrument);
    void use_names();
    void use_columns(size_t width);
    void use_keys(const json::Value &object);
    void use_instrument();
    void use_units(const std::vector<TableColumn> &columns);
    void check_width(const std::vector<std::string> &fields, std::string_view line) const;
    bool lacks(const std::vector<std::string> &fields, size_t place) const;
    std::string wanted_name(size_t column) const;
    std::string with_point(const std::string &field, size_t column);
    double value_of(const std::string &field, size_t column) const;
    double time_of(const std::string &name, const json::Value &value, std::string &warning);
    void see_instruments(const std::vector<std::string> &names, const std::vector<std::string> &fields);
    void warn(const std::string &text);

    SeriesOptions options_;
    SeriesTimes times_;
    TableHeader header_;
    Places places_;
    size_t instrument_ = kNoPlace;
    std::vector<std::string> names_; // of the columns, or keys of the last object
    Unit unit_;
    double sigma_factor_ = 1; // to the unit of y
    Instruments instruments_;
    LikelyInstrument likely_;
    MissingMarks marks_;
    std::vector<std::string> warnings_;
    size_t taken_ = 0; // of the warnings
    int64_t lines_ = 0, missing_ = 0;
    bool known_ = false;   // the layout, from names or a first row
    bool begun_ = false;   // there was a sample
    bool objects_ = false; // JSON Lines
    bool truncated_ = false;
    char point_ = '\0'; // of the decimals: '.' or ',' once one was seen
};

} // namespace toliman::ingest
