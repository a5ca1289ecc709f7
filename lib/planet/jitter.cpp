// Method: the trapezoidal rule in a coordinate s in which the posterior of the jitter has a width of about 1,
//     ds/du = sqrt(I(u)) + c,   I = sum over the measurements of 2 (J^2/(sigma^2 + J^2))^2 (d ln J/du)^2,
// with the share u of the prior and the Fisher information I of the logarithm of the jitter J; c resolves the range
// where the sigmas dominate. For a Gaussian of width 1, steps of 0.75 have an error of 2 exp(-2 (pi/0.75)^2) = 5e-16;
// at the ends of the range, where the integrand does not vanish, it is below 1 %. The terms have one maximum: it is
// found by steps that double, and the sum ends on both sides at terms exp(-9) of it. The grid depends on the series
// alone, so that scaling the sigmas moves the nodes and does not change what they resolve.
//
// Rejected: the jitter as an axis of the lattice. For noise far above the sigmas its posterior is a narrow ridge
// through all orbits, whose cells are then all to be divided: the lattice stopped before that, and gave odds of -68 dex
// for white noise.
// Reference: Trefethen and Weideman (2014), SIAM Rev. 56, 385
#include "planet/jitter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace toliman::planet {

namespace {

constexpr double kStep = 0.75;        // of s
constexpr double kTail = 9;           // of logarithms, below the largest
constexpr double kLeastDensity = 8;   // c
constexpr double kLeastOfKnee = 1e-3; // jitter of the first node without sigmas, of the knee of the prior
constexpr size_t kFine = 1024;        // intervals of u in the integral of ds/du
constexpr double kNone = -std::numeric_limits<double>::infinity();

// Terms of an integral, each computed once.
template <class Term> class Terms {
  public:
    Terms(size_t count, Term term) : values_(count, NAN), term_(term) {}

    double at(size_t i) {
        if (std::isnan(values_[i]))
            values_[i] = term_(i);
        return values_[i];
    }

    // Computes the terms that count, and returns the place of the largest.
    size_t sum(size_t start) {
        const size_t best = highest(start);
        const double least = at(best) - kTail;
        size_t first = best, last = best;
        while (first > 0 && at(first - 1) > least)
            first--;
        while (last + 1 < values_.size() && at(last + 1) > least)
            last++;
        for (size_t i = 0; i < values_.size(); i++)
            if (i < first || i > last)
                values_[i] = kNone;
        return best;
    }

    std::vector<double> &values() noexcept { return values_; }

  private:
    size_t highest(size_t best) {
        for (bool has_moved = true; has_moved;) {
            has_moved = false;
            for (size_t step = 1; best + step < values_.size() && at(best + step) > at(best); step *= 2) {
                best += step;
                has_moved = true;
            }
            for (size_t step = 1; step <= best && at(best - step) > at(best); step *= 2) {
                best -= step;
                has_moved = true;
            }
        }
        return best;
    }

    std::vector<double> values_;
    Term term_;
};

template <class Term> JitterIntegral integral_of(size_t count, size_t start, Term term) {
    Terms<Term> terms(count, term);
    const size_t best = terms.sum(start);
    const double largest = terms.at(best);
    double sum = 0;
    for (const double value : terms.values())
        sum += std::exp(value - largest);
    return {largest + std::log(sum), best};
}

// ds/du, where J = knee (exp(range u) - 1) gives d ln J/du = range (J + knee)/J.
double density(const Series &series, const Prior &prior, double u) noexcept {
    const double jitter = prior.jitter(u), range = std::log1p(prior.jitter_max / prior.jitter_knee);
    double sum = 0;
    for (size_t i = 0; i < series.n; i++) {
        const double scale = series.jitter_scale(i), square = scale * scale;
        const double variance = series.sigma[i] * series.sigma[i] + jitter * jitter * square;
        sum += series.factor[i] > 0 && variance > 0 ? 2 * square * square / (variance * variance) : 0;
    }
    return jitter * (jitter + prior.jitter_knee) * range * std::sqrt(sum) + kLeastDensity;
}

} // namespace

JitterGrid::JitterGrid(const Problem &problem) : problem_(problem) {
    const Prior &prior = problem.prior;
    const Series &series = problem.series;
    if (!(prior.jitter_max > 0)) {
        nodes_.emplace_back(0.0, 0.0, 0.0);
    } else {
        const double range = std::log1p(prior.jitter_max / prior.jitter_knee);
        const double first = series.median_sigma > 0 ? 0 : std::log1p(kLeastOfKnee) / range;
        const double width = (1 - first) / kFine;
        std::vector<double> s(kFine + 1);
        for (size_t k = 0; k < kFine; k++)
            s[k + 1] = s[k] + width * density(series, prior, first + width * (static_cast<double>(k) + 0.5));
        const auto steps = static_cast<size_t>(std::ceil(s[kFine] / kStep));
        const double step = s[kFine] / static_cast<double>(steps);
        size_t k = 0;
        for (size_t i = 0; i <= steps; i++) {
            const double at = std::min(step * static_cast<double>(i), s[kFine]);
            while (k + 1 < kFine && s[k + 1] < at)
                k++;
            const double slope = (s[k + 1] - s[k]) / width;
            const double share = std::min(1.0, first + width * static_cast<double>(k) + (at - s[k]) / slope);
            const double ends = i == 0 || i == steps ? 0.5 : 1;
            nodes_.emplace_back(share, prior.jitter(share), std::log(ends * step / density(series, prior, share)));
        }
    }
    null_ = integral_of(count(), count() - 1, [&](size_t i) { return nodes_[i].log_weight + design(i).log_null(); });
}

double JitterGrid::jitter(size_t node, double part) const noexcept {
    const double here = nodes_[node].share;
    const size_t next = part < 0.5 ? (node > 0 ? node - 1 : node) : (node + 1 < count() ? node + 1 : node);
    return problem_.prior.jitter(here + std::fabs(part - 0.5) * (nodes_[next].share - here));
}

const Design &JitterGrid::design(size_t node) const {
    const Node &at = nodes_[node];
    std::call_once(at.is_made, [&] {
        at.design = std::make_unique<Design>(problem_.series, problem_.functions, problem_.values, at.jitter);
    });
    return *at.design;
}

double JitterGrid::term(ShapeWork &work, const Orbit &orbit, size_t node) const {
    const Design &with = design(node);
    return nodes_[node].log_weight + with.log_null() +
           log_bayes(work.moments(problem_.series, with, orbit), problem_.prior.scales, nullptr);
}

JitterIntegral JitterGrid::at(ShapeWork &work, const Orbit &orbit, size_t start) const {
    return integral_of(count(), start, [&](size_t node) { return term(work, orbit, node); });
}

std::vector<double> JitterGrid::terms(ShapeWork &work, const Orbit &orbit, size_t start) const {
    Terms terms(count(), [&](size_t node) { return term(work, orbit, node); });
    terms.sum(start);
    return std::move(terms.values());
}

} // namespace toliman::planet
