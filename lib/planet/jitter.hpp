// The integral over the jitter, of which all nodes of an orbit share the designs.
#pragma once
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

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
    int star = 0;          // that has the planet
};

// An integral over the jitter: its logarithm, and the node of its largest term.
struct JitterIntegral {
    double log_sum;
    size_t best;
};

class JitterGrid {
  public:
    explicit JitterGrid(const Problem &problem);

    size_t count() const noexcept { return nodes_.size(); }
    double jitter(size_t node) const noexcept { return nodes_[node].jitter; }
    // The jitter at the share `part`, in (0, 1), of the interval of a node.
    double jitter(size_t node, double part) const noexcept;
    // The functions with the jitter of a node. Made by the first caller; threads may share it.
    const Design &design(size_t node) const;

    // The evidence without a planet.
    const JitterIntegral &null() const noexcept { return null_; }
    // The evidence of an orbit. start: a node near its largest term.
    JitterIntegral at(ShapeWork &work, const Orbit &orbit, size_t start) const;
    // [count()], ln of the terms of an orbit; -infinity for those that do not count.
    std::vector<double> terms(ShapeWork &work, const Orbit &orbit, size_t start) const;

  private:
    struct Node {
        double share, jitter, log_weight; // share of the prior
        mutable std::once_flag is_made = {};
        mutable std::unique_ptr<Design> design = {};
        Node(double u, double size, double log) : share(u), jitter(size), log_weight(log) {}
    };

    // ln of a term of the evidence of an orbit.
    double term(ShapeWork &work, const Orbit &orbit, size_t node) const;

    const Problem &problem_;
    std::deque<Node> nodes_; // which do not move
    JitterIntegral null_ = {};
};

} // namespace toliman::planet
