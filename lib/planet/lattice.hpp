// Adaptive quadrature of the posterior over frequency, eccentricity and mean anomaly, of the integral over the jitter.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/progress.hpp"
#include "planet/jitter.hpp"

namespace toliman::planet {

// In the order of the cells.
enum Axis : size_t { kEccentricity, kFrequency, kAnomaly, kAxes };
using Place = std::array<int32_t, kAxes>;

struct Cell {
    Place place;     // in the lattice of its level
    int32_t level;   // index of the boxes of the lattice
    uint32_t jitter; // node of the most probable jitter
    double log_mass;
};

// A box of orbits: ranges of eccentricity, frequency and mean anomaly, with the numbers of its cells.
struct Box {
    std::array<double, kAxes> low, high;
    std::array<int32_t, kAxes> counts;
    bool is_circle = true; // the cells of the anomaly are all around the circle
};

// All orbits of the prior, in boxes that fit into memory. Status::range if they cannot be counted.
std::vector<Box> whole_boxes(const Problem &problem);
// Orbits within some standard errors of one. Anomalies are whole cycles where these are large.
Box box_around(const Problem &problem, const Orbit &orbit, const Orbit &error);

class Lattice {
  public:
    // Progress is reported as `stage` from 0 to 1.
    Lattice(const Problem &problem, const std::vector<Box> &boxes, unsigned threads, const Progress &progress,
            const char *stage);

    // ln of the evidence with one planet, and without it, in the same unit.
    double log_evidence() const noexcept { return log_evidence_; }
    double log_null() const noexcept { return jitters_.null().log_sum; }
    // Error of log_evidence(): its change by the last division of cells, or between the halves of the first cells if
    // none was divided, and the mass of cells that were too many to be divided.
    double log_error() const noexcept { return log_error_; }
    const std::vector<Cell> &cells() const noexcept { return cells_; }
    // A point of a cell, with parts in (0, 1) of its sides.
    Orbit orbit(const Cell &cell, const std::array<double, kAxes> &part) const noexcept;
    const JitterGrid &jitters() const noexcept { return jitters_; }
    // The functions with the most probable jitter without a planet.
    const Design &null_design() const { return jitters_.design(jitters_.null().best); }
    const Cell &best() const noexcept { return cells_[best_]; }
    // The highest nodes of the first cells that have no higher neighbour.
    std::vector<Orbit> peaks() const;

  private:
    using Active = std::vector<Cell>;
    struct Run { // of the evaluations of a search
        unsigned threads;
        const Progress &progress;
        const char *stage;
    };
    Active first_cells(const Box &box);
    // Divides the cells of a box; `from` and `to`: the progress.
    void refine(Active active, const Run &run, double from, double to, size_t &left);
    void evaluate(Active &active, const Run &run, double from, double to);
    // Adds the cells that a peak reaches beyond those that were divided.
    void grow(Active &active, const Run &run, double at, size_t &left);
    void keep_peaks(const Active &active);
    void drop_negligible();
    Active children(const Active &active, const std::array<bool, kAxes> &split);

    const Problem &problem_;
    std::vector<Box> levels_; // each division of a box is another one
    std::vector<Cell> cells_, peaks_;
    double log_rest_, log_left_over_; // of boxes that were not divided; of cells that were too many to be divided
    JitterGrid jitters_;
    double log_evidence_ = 0, log_error_ = 0;
    size_t best_ = 0;
};

} // namespace toliman::planet
