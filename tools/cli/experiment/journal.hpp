// What an experiment has found so far, in a file that grows by whole lines: a stopped experiment goes on from it.
#pragma once
#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "common/json.hpp"

namespace cli {

// A method on one series of frames.
struct Row {
    std::string table, method;
    double amplitude_px = 0; // 0: frames without signal
    uint64_t seed = 0;       // of weights and noise
    uint64_t series = 0;     // number among those without signal of this seed
    double period_days = 0, log10_fap = 0;
    double slope = 0; // of the values over the true displacement in px: regression; without signal the method's answer
                      // to expected images, NaN where it has none
    double sigma = 0; // scatter of the values about that line
    double mean = 0;  // of the values
};

class Journal {
  public:
    // Opens or begins the file; `arguments` stand in its first line. A Failure where it holds other arguments, damaged
    // lines, or where another process writes it. A last line without its end, of a process that died, is cut off.
    Journal(const std::string &path, const JsonTree &arguments);
    ~Journal();
    Journal(const Journal &) = delete;
    Journal &operator=(const Journal &) = delete;

    bool holds(const Row &row) const { return place_.count(key_of(row)) != 0; }
    // Outlives the process when it returns, a failure of the machine within a second.
    void add(const Row &row);
    const std::vector<Row> &rows() const noexcept { return rows_; }

  private:
    static std::string key_of(const Row &row);
    void read(const JsonTree &arguments);
    void check_arguments(const std::string &line, const JsonTree &arguments) const;
    void take(const std::string &line, size_t number);
    void append(const std::string &line);

    std::string path_;
    int file_;
    std::chrono::steady_clock::time_point synced_;
    std::vector<Row> rows_;
    std::map<std::string, size_t> place_;
};

} // namespace cli
