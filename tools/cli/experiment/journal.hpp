// Journal of an experiment: an append-only file with one result per line, from which a stopped experiment resumes.
#pragma once
#include <chrono>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "common/json.hpp"

namespace cli {

// A method on one series of frames.
struct Row {
    std::string table, method;
    double amplitude_px = 0; // 0: frames without signal
    uint64_t seed = 0;       // of weights and noise
    uint64_t series = 0;     // number among the series without signal of this seed
    double period_days = 0, log10_fap = 0;
    double slope = 0; // of the values over the true displacement in px, by regression; without signal by the method's
                      // values on expected images
    double sigma = 0; // scatter of the values about that line
    double mean = 0;  // of the values
};

class Journal {
  public:
    // Opens or creates the file; its first line has the arguments. Throws Failure if the file has other arguments or
    // damaged lines, or if another process writes to it. An incomplete last line, left by a process that died, is
    // removed.
    Journal(const std::string &path, const JsonTree &arguments);
    ~Journal();
    Journal(const Journal &) = delete;
    Journal &operator=(const Journal &) = delete;

    bool contains(const Row &row) const { return known_.count(key_of(row)) != 0; }
    // Appends a result. It survives a crash of the process at once, and a failure of the machine after at most a
    // second.
    void add(const Row &row);
    const std::vector<Row> &rows() const noexcept { return rows_; }

  private:
    using Key = std::tuple<std::string, std::string, double, uint64_t, uint64_t>;
    static Key key_of(const Row &row) { return {row.table, row.method, row.amplitude_px, row.seed, row.series}; }
    void read(const JsonTree &arguments);
    void check_arguments(const std::string &line, const JsonTree &arguments) const;
    Row parse(const std::string &line, size_t number) const;
    void keep(const Row &row);
    void append(const std::string &line);

    std::string path_;
    int file_;
    std::chrono::steady_clock::time_point synced_;
    std::vector<Row> rows_;
    std::set<Key> known_;
};

} // namespace cli
