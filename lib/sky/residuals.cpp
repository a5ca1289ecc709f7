// Method: the residual r = (s - p)/sigma of a measured separation s about its prediction p is explained by a mean m and
// by the errors e_j of the elements, in units of their standard deviations,
//     |r - m/sigma - sum c_j e_j|^2 + sum e_j^2 -> minimum,  c_j = (dp/de_j) sigma_j/sigma.
// Each prior is one more row, so that the rest is what orthonormal vectors leave of r.
// Estimate: a change dv of the velocity towards the stars changes the separation by -s dv/c; a shift of time changes
// the orbit's part like that of its epoch, and the Earth's velocity by its acceleration towards the Sun.
#include "sky/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>

#include "base/constants.hpp"
#include "kernels/project.hpp"
#include "sky/columns.hpp"
#include "sky/reduction.hpp"
#include "sky/time.hpp"
#include "sky/vector.hpp"

namespace toliman::sky {

namespace {

constexpr double kPanel = 120e9;         // ns, of a node
constexpr double kSunGm = 1.32712440e20; // m^3/s^2
constexpr double kSameLength = 1e6;      // ns, of exposures

std::vector<Interval> shifted(std::vector<Interval> intervals, double late_s) {
    const int64_t shift = std::llround(late_s * 1e9);
    for (auto &[start, end] : intervals) {
        start -= shift;
        end -= shift;
    }
    return intervals;
}

// The mean over exposure i, or nothing if the observer has no state for it.
std::optional<Prediction> seen_by(const Predictor &predictor, const std::vector<Measurement> &measurements, size_t i) {
    try {
        const ExposureMean mean = mean_over(predictor, measurements[i].exposure);
        if (mean.outcome == ExposureMean::Outcome::unknown)
            fail(Status::argument, "{intervals}: %s", mean.why.c_str());
        return mean.outcome == ExposureMean::Outcome::known ? std::optional(mean.seen) : std::nullopt;
    } catch (const Error &error) {
        fail_within(error, error.status(), "measurement %zu: %s", i, error.what());
    }
}

int64_t middle_of(const Exposure &exposure) noexcept {
    const auto [start, end] = exposure.intervals.front();
    return start + (end - start) / 2;
}

double length_of(const Exposure &exposure) noexcept {
    double length = 0;
    for (const auto &[start, end] : exposure.intervals)
        length += static_cast<double>(end - start);
    return length;
}

// Derivative of the Earth's velocity in a direction, m/s^2.
double earth_pull(const Earth &earth, int64_t tai_ns, const Vector &direction) {
    constexpr double kAu = erfa::kAstronomicalUnit;
    const Vector from_sun = earth.at(terrestrial_days(tai_ns)).earth.from_sun; // au
    const double distance = length(from_sun);
    return -kSunGm / (kAu * kAu) * dot(direction, from_sun) / (distance * distance * distance);
}

} // namespace

Residuals::Residuals(const Predictor &predictor, const std::vector<Measurement> &measurements, double scale_sigma,
                     size_t most)
    : predictor_(predictor) {
    const Barycentre &centre = predictor.system().value.barycentre;
    const double ra = centre.ra_deg * kDegree, dec = centre.dec_deg * kDegree;
    towards_ = {std::cos(dec) * std::cos(ra), std::cos(dec) * std::sin(ra), std::sin(dec)};
    const std::vector<Column> errors = error_columns(predictor.system(), scale_sigma);
    columns_.resize(errors.size());
    const size_t stride = std::max<size_t>((measurements.size() + most - 1) / most, 1);
    for (size_t i = 0; i < measurements.size(); i += stride) {
        const std::optional<Prediction> seen = seen_by(predictor, measurements, i);
        if (!seen)
            continue;
        const Measurement &one = measurements[i];
        used_.push_back(one);
        seen_.push_back(*seen);
        before_.push_back((one.separation_arcsec - seen->separation_arcsec) / one.sigma_arcsec);
        for (size_t c = 0; c < errors.size(); c++)
            columns_[c].push_back(seen->partials[errors[c].element] * seen->factor * errors[c].sigma /
                                  one.sigma_arcsec);
        earth_pull_.push_back(earth_pull(predictor.earth(), middle_of(one.exposure), towards_));
        nodes_.push_back(nodes_of(one.exposure));
    }
    set_slow();
    basis_ = basis_of(before_, Free::slow, rank_);
}

std::vector<Residuals::Node> Residuals::nodes_of(const Exposure &exposure) const {
    const double whole = length_of(exposure);
    std::vector<Node> nodes;
    for (const auto &[start, end] : exposure.intervals) {
        const auto length = static_cast<double>(end - start);
        const double panels = std::max(1.0, std::ceil(length / kPanel));
        for (double panel = 0; panel < panels; panel++) {
            Node node = {start + std::llround(length * (panel + 0.5) / panels), whole > 0 ? length / panels / whole : 1,
                         0};
            node.approach_m_s = spacecraft_approach(node, {});
            nodes.push_back(node);
        }
    }
    return nodes;
}

// Of the spacecraft, in m/s; NaN without a state.
double Residuals::spacecraft_approach(const Node &node, const Change &change) const {
    const int64_t tai_ns = node.tai_ns - std::llround(change.late_s * 1e9);
    if (!predictor_.observer().covers(tai_ns))
        return kNaN;
    const State state = predictor_.observer().at(tai_ns);
    double approach = 0;
    for (size_t i = 0; i < 3; i++)
        approach += towards_[i] * dot({change.axes[3 * i], change.axes[3 * i + 1], change.axes[3 * i + 2]},
                                      vector_of(state.velocity_m_s));
    return approach;
}

double Residuals::exposure_s() const noexcept {
    double first = used_.empty() ? 0 : length_of(used_.front().exposure);
    for (const Measurement &one : used_)
        if (std::fabs(length_of(one.exposure) - first) > kSameLength || one.exposure.intervals.size() != 1)
            return 0;
    return first * 1e-9;
}

int64_t Residuals::middle_ns() const noexcept {
    return used_.empty() ? 0 : middle_of(used_[used_.size() / 2].exposure);
}

Residuals::Values Residuals::after(const Change &change) const {
    const Predictor changed(predictor_, predictor_.observer().turned(change.axes));
    Values values;
    for (const Measurement &one : used_) {
        values.push_back(kNaN);
        try {
            const double predicted = changed.mean(shifted(one.exposure.intervals, change.late_s)).separation_arcsec;
            values.back() = (one.separation_arcsec - predicted) / one.sigma_arcsec;
        } catch (const NoState &) { // stays NaN
        }
    }
    return values;
}

Residuals::Values Residuals::estimate(const Change &change) const {
    Values values = before_;
    for (size_t m = 0; m < used_.size(); m++) {
        const Prediction &seen = seen_[m];
        double approach = -earth_pull_[m] * change.late_s;
        for (const Node &node : nodes_[m])
            approach += node.weight * (spacecraft_approach(node, change) - node.approach_m_s);
        const double by_orbit =
            seen.partials[kElements - 1] * seen.factor * change.late_s / (kDaysPerYear * kSecondsPerDay);
        const double by_velocity = -seen.separation_arcsec * approach / erfa::kLightSpeed;
        values[m] -= (by_orbit + by_velocity) / used_[m].sigma_arcsec;
    }
    return values;
}

Residuals::Values Residuals::scale() const {
    Values values;
    for (size_t m = 0; m < used_.size(); m++)
        values.push_back(-seen_[m].separation_arcsec / used_[m].sigma_arcsec);
    return values;
}

void Residuals::set_slow() {
    constexpr double kYear = kSecondsPerDay * kDaysPerYear * 1e9; // ns
    int64_t first = INT64_MAX, last = INT64_MIN;
    for (const Measurement &one : used_) {
        first = std::min(first, middle_of(one.exposure));
        last = std::max(last, middle_of(one.exposure));
    }
    slow_.assign(static_cast<size_t>(Free::slow), {});
    for (const Measurement &one : used_) {
        const int64_t time = middle_of(one.exposure);
        const double angle = 2 * kPi * static_cast<double>(time) / kYear;
        const double span = std::max(1.0, static_cast<double>(last - first));
        const double x = 2 * static_cast<double>(time - first) / span - 1, x2 = x * x;
        const double values[] = {1,  std::cos(angle), std::sin(angle), std::cos(2 * angle), std::sin(2 * angle), x,
                                 x2, x2 * x,          x2 * x2};
        static_assert(std::size(values) == static_cast<size_t>(Free::slow));
        for (size_t f = 0; f < slow_.size(); f++)
            slow_[f].push_back(values[f] / one.sigma_arcsec);
    }
}

std::vector<double> Residuals::basis_of(const Values &used, Free free, size_t &rank) const {
    const size_t n = used.size(), rows = n + columns_.size(), freely = static_cast<size_t>(free);
    std::vector<double> basis((columns_.size() + freely) * rows);
    for (size_t m = 0; m < n; m++) {
        if (std::isnan(used[m]))
            continue;
        for (size_t c = 0; c < columns_.size(); c++)
            basis[c * rows + m] = columns_[c][m];
        for (size_t f = 0; f < freely; f++)
            basis[(columns_.size() + f) * rows + m] = slow_[f][m];
    }
    for (size_t c = 0; c < columns_.size(); c++)
        basis[c * rows + n + c] = 1;
    rank = kernels::orthonormalise(basis.data(), columns_.size() + freely, rows);
    return basis;
}

std::vector<double> Residuals::rest(const Values &values, const Values &used, Free free) const {
    const size_t n = values.size();
    std::vector<double> rest(n + columns_.size());
    bool is_whole = true;
    for (size_t m = 0; m < n; m++) {
        const bool is_used = !std::isnan(used[m]);
        is_whole &= is_used;
        rest[m] = is_used ? values[m] : 0;
    }
    if (is_whole && free == Free::slow) {
        kernels::project_out_twice(basis_.data(), rank_, rest.size(), rest.data());
        return rest;
    }
    size_t rank = 0;
    const std::vector<double> basis = basis_of(used, free, rank);
    kernels::project_out_twice(basis.data(), rank, rest.size(), rest.data());
    return rest;
}

} // namespace toliman::sky
