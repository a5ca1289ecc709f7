// Series of samples: text with comments and a line of names or none, JSON Lines, or a .npy table.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/failure.hpp"

namespace cli {

struct Sample {
    double t, y, sigma; // sigma 1 where the series has none
};

// A line that is no sample; those after it may be.
class BadLine : public Failure {
  public:
    explicit BadLine(const std::string &text) : Failure(kExitInput, text) {}
};

constexpr char kCutRemark[] = ": has no line end, so that the last number may be cut";

// Samples line by line, as they come. Columns are t,y or t,y,sigma. With a line of names they stand anywhere among
// others, and `columns` may be other names for them: {"t", "latent"}; keys of JSON objects likewise. Every malformed
// line is a BadLine that names file, line, column and what is allowed; reading may go on after it.
class SampleReader {
  public:
    // path: a file, or - for standard input
    SampleReader(const std::string &path, const std::vector<std::string> &columns);
    // Of lines that someone is still writing: `awake` as of LineSource, and a last line without newline, which may be
    // cut, is a BadLine.
    SampleReader(const std::string &path, const std::vector<std::string> &columns, std::function<void()> awake);
    ~SampleReader();
    SampleReader(const SampleReader &) = delete;
    SampleReader &operator=(const SampleReader &) = delete;

    // False at the end.
    bool next(Sample &sample);
    const std::string &name() const noexcept; // as messages call the file
    std::string where() const;                // the last line, "rv.csv:7"
    bool weighted() const noexcept;           // samples have a sigma
    bool empty() const noexcept;              // no line was read
    bool cut() const noexcept;                // the last line of columns has no line end

  private:
    class Lines;
    std::unique_ptr<Lines> lines_;
};

struct Series {
    std::string name;                // as messages call the file
    std::vector<double> t, y, sigma; // sigma empty when the file has none
    std::string remark = {};         // a warning, "" for none
};

// All samples of a file, at least one; .npy files too: float64 [samples][2 or 3].
Series read_series(const std::string &name, const std::vector<std::string> &columns = {});

} // namespace cli
