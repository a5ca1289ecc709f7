// Method: files are mislabelled more often than they are damaged, and an observer's velocity that is wrong by 1 m/s
// shifts the separation by 0.03 uas. Three checks find wrong units, columns and axes without knowing the orbit.
//  - Distance and speed are those of a spacecraft near the Earth: numbers in m instead of km are beyond them.
//  - From one state to the next, h later, the position changes by the integral of the velocity:
//        |dr/h - mean v| <= 1 m/s + 4 d + 2 m/h.
//  - Below 50,000 km the velocity changes by the integral of the Earth's attraction g = -GM r/|r|^3:
//        |dv/h - mean g| <= 3 % |mean g| + 4 d + 0.1 m/s/h.
//    The flattening of the Earth is 0.3 %; in axes that rotate with the Earth 10 % or more are missing somewhere along
//    the orbit.
// Means are integrals of Lagrange's polynomial through eight states, by Gauss's rule with four nodes, which is exact;
// d is the sum of the changes from four to six and from six to eight points. Above 30 m/s of d
// states are too far apart to conclude anything.
// Derivatives of positions were rejected: at the ends of a segment they multiply rounding errors by 46/h. The third
// terms allow for rounded numbers, the second ones for states that are far apart. States closer than a minute are
// compared with the state a minute later, because noise of the positions is divided by h. Weights are computed again
// only if the steps change. Reference: Vallado, Fundamentals of Astrodynamics and Applications, ch. 8.
#include "sky/segment_builder.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "sky/interpolation.hpp"
#include "sky/lagrange.hpp"
#include "sky/observer.hpp"
#include "sky/vector.hpp"

namespace toliman::sky {

// Weights of eight values for their mean from the node `left` to the next one, and of the six and four nearest of them.
struct MeanWeights {
    std::array<double, Ephemeris::kPoints> eight = {}, six = {}, four = {};
};

namespace {

constexpr double kLeastDistance = 6.378e6, kMostDistance = 3e9;    // m
constexpr double kMostSpeed = 12e3, kLowDistance = 5e7;            // m/s, m
constexpr double kUsualInterval = 60;                              // s
constexpr double kVelocityLimit = 1, kPositionRounding = 2;        // m/s, m
constexpr double kAttractionLimit = 0.03, kVelocityRounding = 0.1; // relative, m/s
constexpr double kDoubtLimit = 4;                                  // changes from 4 to 6 to 8 points
constexpr double kUnresolved = 30;                                 // m/s
constexpr size_t kPoints = Ephemeris::kPoints;                     // of the interpolation

double distance(const Vector &a, const Vector &b) noexcept {
    return length(sum(a, -1, b));
}

// The change of a vector per second.
Vector rate(const double from[3], const double to[3], double seconds) noexcept {
    return sum({}, 1 / seconds, sum(vector_of(to), -1, vector_of(from)));
}

Vector attraction(const State &state) noexcept {
    const Vector place = vector_of(state.position_m);
    const double distance = length(place);
    return sum({}, -kEarthGm / (distance * distance * distance), place);
}

// Gauss's rule with four nodes.
template <size_t kCount>
std::array<double, kPoints> mean_weights(const std::array<int64_t, kPoints> &times, size_t left) noexcept {
    constexpr double kNodes[] = {-0.86113631159405258, -0.33998104358485626, 0.33998104358485626, 0.86113631159405258};
    constexpr double kWeights[] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
    constexpr size_t kLeft = kCount / 2 - 1; // if the nodes are on both sides
    const size_t skipped = std::clamp<size_t>(left, kLeft, kLeft + kPoints - kCount) - kLeft;
    const LagrangeNodes<kCount> nodes(times.data() + skipped);
    const auto step = static_cast<double>(times[left + 1] - times[left]);
    std::array<double, kPoints> out = {};
    for (size_t node = 0; node < 4; node++) {
        const auto weights = nodes.at(times[left] + static_cast<int64_t>((1 + kNodes[node]) / 2 * step));
        for (size_t i = 0; i < kCount; i++)
            out[skipped + i] += kWeights[node] * weights[i];
    }
    return out;
}

Vector sum_of(const std::array<Vector, kPoints> &values, const std::array<double, kPoints> &weights) noexcept {
    Vector out = {};
    for (size_t i = 0; i < kPoints; i++)
        out = sum(out, weights[i], values[i]);
    return out;
}

// A mean, and the changes from four to six to eight points.
struct Mean {
    Vector value;
    double doubt;
};

Mean mean_of(const std::array<Vector, kPoints> &values, const MeanWeights &weights) noexcept {
    const Vector eight = sum_of(values, weights.eight), six = sum_of(values, weights.six);
    return {eight, distance(eight, six) + distance(six, sum_of(values, weights.four))};
}

} // namespace

double number_of(std::string_view text) noexcept {
    double value = 0;
    if (!text.empty() && text[0] == '+' && text.substr(1, 1) != "-")
        text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
    return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

void SegmentBuilder::add(int64_t tai_ns, const State &state, int line) {
    const double distance = length(vector_of(state.position_m)), speed = length(vector_of(state.velocity_m_s));
    if (!(distance >= kLeastDistance && distance <= kMostDistance))
        fail(
            Status::format,
            "{%s}:%d: the position is %.6g km from the Earth's centre: must be in [6378, 3e6] km; positions must be in "
            "%s and velocities in %s",
            path_.c_str(), line, distance * 1e-3, units_.position, units_.velocity);
    if (!(speed <= kMostSpeed))
        fail(Status::format,
             "{%s}:%d: the speed is %.6g km/s: must be at most 12 km/s; positions must be in %s and velocities in %s",
             path_.c_str(), line, speed * 1e-3, units_.position, units_.velocity);
    if (!is_empty() && tai_ns <= last_ns())
        fail(Status::format, "{%s}:%d: the time, %s TAI, must be after that of the state before, %s TAI", path_.c_str(),
             line, ingest::date_text(tai_ns).c_str(), ingest::date_text(last_ns()).c_str());
    segment_.tai_ns.push_back(tai_ns);
    segment_.states.push_back(state);
    lines_.push_back(line);
}

Segment SegmentBuilder::finish(const Log &log) {
    const size_t states = segment_.states.size();
    if (states < kPoints)
        fail(Status::format, "{%s}:%d: the segment that begins here has %zu states: must have at least %zu",
             path_.c_str(), lines_[0], states, kPoints);
    const double step = static_cast<double>(last_ns() - first_ns()) * 1e-9 / static_cast<double>(states - 1);
    const size_t most = std::max<size_t>((states - 1) / kPoints, 1);
    check_motion(static_cast<size_t>(std::min(std::ceil(kUsualInterval / step), static_cast<double>(most))));
    warn_of_gaps(log);
    segment_.first_ns = first_ns();
    segment_.last_ns = last_ns();
    return std::move(segment_);
}

// Two states, and the eight with which the interval between them is checked: `stride` apart, from `first` on.
struct SegmentBuilder::Interval {
    size_t from, stride, first;
    double seconds;
    MeanWeights weights;

    size_t to() const noexcept { return from + stride; }

    // stride is 1, or at most an eighth of the intervals of the segment.
    void move_to(size_t state, const std::vector<int64_t> &times) noexcept {
        const size_t before = state / stride, after = std::min((times.size() - 1 - state) / stride, kPoints - 1);
        const size_t now_left = std::max(std::min<size_t>(before, 3), kPoints - 1 - after);
        from = state;
        first = from - now_left * stride;
        seconds = static_cast<double>(times[to()] - times[from]) * 1e-9;
        std::array<int64_t, kPoints> found;
        for (size_t i = 0; i < kPoints; i++)
            found[i] = times[first + i * stride] - times[from];
        if (found != offsets) // of which 0 is that of `from`
            weights = {mean_weights<kPoints>(found, now_left), mean_weights<6>(found, now_left),
                       mean_weights<4>(found, now_left)};
        offsets = found;
    }

    // The mean of a function of the states.
    template <class Value> Mean mean(const std::vector<State> &states, Value value) const noexcept {
        std::array<Vector, kPoints> values;
        for (size_t i = 0; i < kPoints; i++)
            values[i] = value(states[first + i * stride]);
        return mean_of(values, weights);
    }

    std::array<int64_t, kPoints> offsets = {}; // times of the eight, for which the weights are
};

void SegmentBuilder::check_motion(size_t stride) const {
    Interval interval = {};
    interval.stride = stride;
    for (size_t from = 0; from + stride < segment_.states.size(); from++) {
        interval.move_to(from, segment_.tai_ns);
        if (check_velocity(interval))
            check_attraction(interval);
    }
}

// False if the states are too far apart to tell.
bool SegmentBuilder::check_velocity(const Interval &interval) const {
    const auto velocity_of = [](const State &state) { return vector_of(state.velocity_m_s); };
    const Mean velocity = interval.mean(segment_.states, velocity_of);
    if (velocity.doubt > kUnresolved)
        return false;
    const State &from = segment_.states[interval.from], &to = segment_.states[interval.to()];
    const Vector moved = rate(from.position_m, to.position_m, interval.seconds);
    const double error = distance(moved, velocity.value);
    const double most = kVelocityLimit + kDoubtLimit * velocity.doubt + kPositionRounding / interval.seconds;
    if (!(error <= most))
        fail(
            Status::format,
            "{%s}:%d: up to line %d, %.6g s later, the position changes by %.6g m/s and the mean velocity is %.6g m/s: "
            "must differ by at most %.3g m/s, not by %.6g: wrong units, columns or axes, or states too far apart; "
            "positions must be in %s and velocities in %s",
            path_.c_str(), line_of(interval.from), line_of(interval.to()), interval.seconds, length(moved),
            length(velocity.value), most, error, units_.position, units_.velocity);
    return true;
}

void SegmentBuilder::check_attraction(const Interval &interval) const {
    const State &from = segment_.states[interval.from], &to = segment_.states[interval.to()];
    if (length(vector_of(from.position_m)) > kLowDistance || length(vector_of(to.position_m)) > kLowDistance)
        return;
    const Mean pull = interval.mean(segment_.states, attraction);
    const double strength = length(pull.value);
    const Vector accelerated = rate(from.velocity_m_s, to.velocity_m_s, interval.seconds);
    const double excess = distance(accelerated, pull.value);
    const double most = kAttractionLimit * strength + kDoubtLimit * pull.doubt + kVelocityRounding / interval.seconds;
    if (!(excess <= most))
        fail(
            Status::format,
            "{%s}:%d: up to line %d, %.6g s later, the velocity changes by %.4g m/s^2, of which %.4g m/s^2 are not the "
            "Earth's attraction: must be at most %.3g m/s^2; axes must not rotate with the Earth (ITRF), and after a "
            "manoeuvre a new segment must begin",
            path_.c_str(), line_of(interval.from), line_of(interval.to()), interval.seconds, length(accelerated),
            excess, most);
}

void SegmentBuilder::warn_of_gaps(const Log &log) const {
    size_t gaps = 0, first = 0;
    for (size_t i = 0; i + 1 < segment_.tai_ns.size(); i++) {
        const int64_t from = segment_.tai_ns[i], to = segment_.tai_ns[i + 1];
        if (interpolate(segment_, i + 1, from + (to - from) / 2).doubt_m_s <= kMostDoubt)
            continue;
        first = gaps == 0 ? i : first;
        gaps++;
    }
    if (gaps > 0)
        log.warn(
            "%s:%d: the next state is %.6g s later, too far to interpolate velocities to 1 m/s: times between them "
            "are refused (%zu such places)",
            path_.c_str(), line_of(first),
            static_cast<double>(segment_.tai_ns[first + 1] - segment_.tai_ns[first]) * 1e-9, gaps);
}

void append_segment(std::vector<Segment> &segments, Segment segment, const ingest::TextPlace &place) {
    if (!segments.empty() && segment.first_ns < segments.back().last_ns)
        fail(Status::format,
             "{%s}:%d: the segment is usable from %s TAI: must not begin before the one before it ends, %s TAI",
             place.path, place.line, ingest::date_text(segment.first_ns).c_str(),
             ingest::date_text(segments.back().last_ns).c_str());
    segments.push_back(std::move(segment));
}

} // namespace toliman::sky
