// Warnings about the time stamps of a pair.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <string>
#include <vector>

#include "ingest/side_line.hpp"

namespace toliman::ingest {

// Upper median of a growing set of numbers: two heaps, logarithmic time per number.
class Median {
  public:
    void add(double value);
    double value() const noexcept { return upper_.empty() ? 0 : upper_.top(); } // 0 if there is none

  private:
    std::priority_queue<double> lower_;
    std::priority_queue<double, std::vector<double>, std::greater<>> upper_; // as many as lower_, or one more
};

// Whether two clocks advance by the same time, in s.
bool advances_alike(double camera_s, double host_s) noexcept;

class ClockChecks {
  public:
    // A line was read: its distance from the line before counts for the usual step.
    void count(const SideLine &line);
    double usual_step_ns() const noexcept { return steps_.value(); } // 0: unknown
    // Warnings about a valid line, by its number in the file; empty if there is none.
    std::string jump(const SideLine &line, int64_t number) const;
    std::string drift(const SideLine &line) const;
    // exposure_s: of both frames; 0: unknown.
    std::string overlap(const SideLine &line, double exposure_s) const;
    // A valid line was reported; later ones are compared with it.
    void pass(const SideLine &line, int64_t number);

  private:
    struct Passed {
        SideLine line;
        int64_t number;
    };
    std::optional<SideLine> counted_; // the line read last, if it is valid
    std::optional<Passed> first_, last_;
    bool last_stands_ = false; // last_ has the time of the line before it
    Median steps_;             // ns
};

} // namespace toliman::ingest
