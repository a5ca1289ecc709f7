// Reads samples one by one: text with or without a line of names, or JSON Lines.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/failure.hpp"
#include "common/lines.hpp"
#include "common/terminal.hpp"
#include "series/times.hpp"

struct cJSON;

namespace cli {

constexpr size_t kFewestColumns = 2, kMostColumns = 3;
constexpr const char *kSampleNames[kMostColumns] = {"t", "y", "sigma"};

// The range that a value of a column violates; nullptr: none.
const char *flaw_of(double value, size_t column) noexcept;

// The fields of a line, without surrounding white space and quotes; at least one.
std::vector<std::string> split(const std::string &line, char separator);

struct Sample {
    double t, y, sigma; // sigma is 1 if the series has none
};

// A line that is not a sample; later lines may be.
class BadLine : public Failure {
  public:
    explicit BadLine(const std::string &text) : Failure(kExitInput, text) {}
};

constexpr char kTruncatedWarning[] = ": has no newline at its end; its last number may be truncated";

// Samples line by line, as they arrive. Columns are t,y or t,y,sigma. With a line of names they may be anywhere among
// others, and `columns` gives other names for them, such as {"t", "latent"}; likewise for keys of JSON objects. Times
// that are dates or days of a time scale become Modified Julian Days. Every malformed line throws a BadLine that names
// file, line, column and what is allowed; reading can continue after it.
class SampleReader {
  public:
    // path: a file, or - for standard input
    SampleReader(const std::string &path, const std::vector<std::string> &columns, const TimeOptions &times)
        : in_(path, stop_if_asked), wanted_(columns), times_(times), complete_(false) {}
    // For input that another process is still writing: on_idle as in LineSource; a last line without newline may be
    // truncated and is a BadLine.
    SampleReader(const std::string &path, const std::vector<std::string> &columns, const TimeOptions &times,
                 std::function<void()> on_idle)
        : in_(path, std::move(on_idle)), wanted_(columns), times_(times), complete_(true) {}

    // False at the end.
    bool next(Sample &sample);
    const std::string &name() const noexcept { return in_.name(); }              // the file's name in messages
    std::string where() const { return name() + ":" + std::to_string(number_); } // the last line's, "rv.csv:7"
    bool weighted() const noexcept { return columns_.size() == kMostColumns; }   // samples have a sigma
    std::string time_scale() const { return times_.scale(); } // of Modified Julian Days; empty for plain numbers
    bool empty() const noexcept { return number_ == 0; }      // no line was read
    bool truncated() const noexcept { return truncated_; }    // the last line of columns has no newline

  private:
    [[noreturn]] void bad(const std::string &why) const { throw BadLine(where() + ": " + why); } // not a sample
    [[noreturn]] void bad_file(const std::string &why) const { malformed(where(), why); }        // all is unusable
    void begin(std::string &line) const;
    bool parse_fields(const std::vector<std::string> &fields, const std::string &line, Sample &sample);
    void parse_object(const std::string &line, Sample &sample);
    void use_names(const std::vector<std::string> &fields);
    void use_positions(size_t count);
    double time_of(const std::string &name, const std::string &field);
    double time_of(const std::string &name, const cJSON *item);
    double value_of(const std::string &field, size_t column) const;

    LineSource in_;
    std::vector<std::string> wanted_;
    Times times_;
    std::string time_name_;       // of the line of names; empty without one
    bool times_known_ = false;    // from a first sample
    bool complete_;               // the last line must have its newline
    std::vector<size_t> columns_; // indices of t, y and sigma in a line
    size_t width_ = 0;            // fields of every line
    size_t number_ = 0;           // of the line
    bool format_known_ = false;   // from a line of names or a first sample
    bool objects_ = false;        // JSON Lines
    bool truncated_ = false;      // the last sample's line has no newline
    char separator_ = ',';
};

} // namespace cli
