// Adaptive quadrature of the posterior over frequency, eccentricity, mean anomaly and jitter.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "base/progress.hpp"
#include "planet/design.hpp"
#include "planet/marginal.hpp"
#include "planet/prior.hpp"

namespace toliman::planet {

// Data of one candidate: those without the signals of the planets before it, whose derivatives are among the functions.
struct Problem {
    const Series &series;
    const Prior &prior;
    std::vector<const Function *> functions;
    Buffer<double> values; // [rows]
};

// In the order of the cells: those of one orbit, with all jitters, are neighbours.
enum Axis : size_t { kEccentricity, kFrequency, kAnomaly, kJitter, kAxes };
using Place = std::array<int32_t, kAxes>;

struct Cell {
    Place place;   // in the lattice of its level
    int32_t level; // index of Lattice::levels
    double log_mass;
};

// Numbers of cells of each axis.
struct Level {
    std::array<int32_t, kAxes> counts;
};

// A point of a cell, with parts in (0, 1) of its sides.
struct Node {
    Orbit orbit;
    double jitter;
};

class Lattice {
  public:
    // Progress is reported as `stage` from 0 to 1.
    Lattice(const Problem &problem, unsigned threads, const Progress &progress, const char *stage);

    // ln of the evidence with one planet, and without it, in the same unit.
    double log_evidence() const noexcept { return log_evidence_; }
    double log_null() const noexcept { return log_null_; }
    const std::vector<Cell> &cells() const noexcept { return cells_; }
    Node node(const Cell &cell, const std::array<double, kAxes> &part) const noexcept;
    // The functions with the jitter at the centre of a cell.
    const Design &design(const Cell &cell) const;
    const Design &null_design() const noexcept { return *null_; } // with the most probable jitter without a planet
    const Cell &best() const noexcept { return cells_[best_]; }
    // False if the lattice had too many cells before neighbours agreed: the evidence is then uncertain.
    bool is_resolved() const noexcept { return is_resolved_; }

  private:
    using Active = std::vector<Cell>;
    void set_null(unsigned threads);
    void set_first_level();
    void prepare(const Active &active);
    void evaluate(Active &active, unsigned threads, const Progress &progress, double from, double to);
    Active children(const Active &active, const std::array<bool, kAxes> &split);
    const Design &design(int32_t count, int32_t place) const;

    const Problem &problem_;
    const char *stage_;
    std::vector<Level> levels_;
    std::vector<Cell> cells_;
    std::map<std::array<int32_t, 2>, std::unique_ptr<Design>> designs_; // (number of cells, place) of the jitter
    std::unique_ptr<Design> null_;
    double log_evidence_ = 0, log_null_ = 0;
    size_t best_ = 0;
    bool is_resolved_ = true;
};

} // namespace toliman::planet
