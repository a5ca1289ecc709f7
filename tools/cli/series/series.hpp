// Reads time series: text with or without a line of names, JSON Lines, or a .npy table.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/failure.hpp"

namespace cli {

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
// others, and `columns` gives other names for them, such as {"t", "latent"}; likewise for keys of JSON objects. Every
// malformed line throws a BadLine that names file, line, column and what is allowed; reading can continue after it.
class SampleReader {
  public:
    // path: a file, or - for standard input
    SampleReader(const std::string &path, const std::vector<std::string> &columns);
    // For input that another process is still writing: on_idle as in LineSource; a last line without newline may be
    // truncated and is a BadLine.
    SampleReader(const std::string &path, const std::vector<std::string> &columns, std::function<void()> on_idle);
    ~SampleReader();
    SampleReader(const SampleReader &) = delete;
    SampleReader &operator=(const SampleReader &) = delete;

    // False at the end.
    bool next(Sample &sample);
    const std::string &name() const noexcept; // the file's name in messages
    std::string where() const;                // the last line's, "rv.csv:7"
    bool weighted() const noexcept;           // samples have a sigma
    bool empty() const noexcept;              // no line was read
    bool truncated() const noexcept;          // the last line of columns has no newline

  private:
    class Lines;
    std::unique_ptr<Lines> lines_;
};

struct Series {
    std::string name;                // the file's name in messages
    std::vector<double> t, y, sigma; // sigma is empty if the file has none
    std::string warning = {};        // "" for none
};

// All samples of a file, at least one; also of .npy files, float64 [samples][2 or 3].
Series read_series(const std::string &name, const std::vector<std::string> &columns = {});

} // namespace cli
