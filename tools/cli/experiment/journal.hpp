// Journal of an experiment: an append-only file with one result per line, from which a stopped experiment resumes.
#pragma once
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "common/journal_file.hpp"

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
    // damaged lines, or if another process writes to it.
    Journal(const std::string &path, const Json &arguments);

    bool contains(const Row &row) const { return rows_.count(row) != 0; }
    void add(const Row &row);
    // The results of a method in a table, by seed and series. amplitude_px 0: all series without signal.
    std::vector<Row> rows(const std::string &table, const std::string &method, double amplitude_px) const;

  private:
    struct Order {
        bool operator()(const Row &a, const Row &b) const {
            return std::tie(a.table, a.method, a.amplitude_px, a.seed, a.series) <
                   std::tie(b.table, b.method, b.amplitude_px, b.seed, b.series);
        }
    };
    Row parse(const std::string &line, size_t number) const;

    JournalFile file_;
    std::set<Row, Order> rows_;
};

} // namespace cli
