// Parses the lines of a time series to samples.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "backend/json.hpp"
#include "ingest/time_scale.hpp"

namespace toliman::ingest {

struct SeriesOptions {
    std::string name;                 // of the input, for messages; may be empty
    std::vector<std::string> columns; // names of t, y and perhaps sigma; empty: the default names
    bool growing, plain_times;        // as in series.h
    std::optional<TimeFormat> format; // empty: from the first time and the column's name
    Scale scale;
    LeapSeconds leap_seconds;
};

// The fields of a line, without surrounding white space and quotes; at least one. A blank separates by white space.
std::vector<std::string> split(std::string_view line, char separator);

struct Sample {
    double t, y, sigma; // sigma is 0 if the series has none
};

class Series {
  public:
    explicit Series(SeriesOptions options) : options_(std::move(options)) {}

    // Empty for comments, empty lines and the line of names. Status::format: the line is malformed, later ones may be
    // samples. Status::mismatch: the input has no such columns. Other errors change nothing.
    std::optional<Sample> parse(std::string_view line);

    int64_t lines() const noexcept { return lines_; }
    bool truncated() const noexcept { return truncated_; }
    std::optional<TimeFormat> format() const noexcept { return format_; } // empty for plain numbers
    Scale scale() const noexcept { return options_.scale == Scale::utc ? Scale::tai : options_.scale; }

  private:
    std::optional<Sample> parse_line(std::string_view line);
    std::optional<Sample> parse_fields(const std::vector<std::string> &fields, std::string_view line);
    Sample parse_object(const std::string &line);
    void use_names(const std::vector<std::string> &fields);
    void use_positions(size_t count);
    void use_times(const std::string &column, const std::string &first);
    double day_of(const std::string &text) const;
    double time_of(const std::string &name, const json::Value *value);
    double value_of(const std::string &field, size_t column) const;

    SeriesOptions options_;
    std::string time_name_;            // of the line of names; empty without one
    std::optional<TimeFormat> format_; // of the times
    std::vector<size_t> columns_;      // indices of t, y and sigma in a line
    size_t width_ = 0;                 // fields of every line
    int64_t lines_ = 0;
    bool known_ = false;       // the format, from a line of names or a first sample
    bool times_known_ = false; // their format, from a first sample
    bool objects_ = false;     // JSON Lines
    bool truncated_ = false;
    char separator_ = ',';
};

} // namespace toliman::ingest
