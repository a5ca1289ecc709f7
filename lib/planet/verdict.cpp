// Method: a Bayes factor compares two models, and is large where both are wrong. Each reason is a property that a
// planet has and that a wrong model, a wrong unit or a wrong time need not have.
//
// The orbit's false alarm probability: at one frequency, the largest power of a sinusoid has the distribution of
// chi-square with 2 degrees of freedom, z being half of it; the two numbers of its shape, eccentricity and anomaly, add
// a factor of the order of z (Baluev 2015, MNRAS 446, 1478), here 20 z. It is needed for eccentric orbits, whose
// sinusoids are weak, and for no more than the agreement of the two numbers.
//
// Orbits of one star cross if the larger one's periastron is within the apastron of the smaller one; semi-major axes
// are as period^(2/3). A distance of 5 % is needed, as neighbours closer than that do not last (Gladman 1993, Icarus
// 106, 247, for two Earths at 1 au: 3 %).
#include "planet/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/robust.hpp"
#include "period/fap.hpp"
#include "planet/detection.hpp"
#include "planet/orientation.hpp"

namespace toliman::planet {

namespace {

constexpr double kShapes = 20;
constexpr double kOutsideMargin = 10;  // of the sum of squares: 2 ln of the number of frequencies
constexpr double kOutsideStep = 0.1;   // of 1/span
constexpr double kMostOutside = 50000; // outside the prior
constexpr double kLeastDistance = 1.05, kMostApart = 0.05;

// Median step between different times.
double median_step(const Series &series) {
    std::vector<double> times(series.t.begin(), series.t.begin() + static_cast<std::ptrdiff_t>(series.n));
    std::sort(times.begin(), times.end());
    std::vector<double> steps;
    for (size_t i = 1; i < times.size(); i++)
        if (times[i] > times[i - 1])
            steps.push_back(times[i] - times[i - 1]);
    return median(std::move(steps));
}

} // namespace

double log10_fap_of_orbit(const Squares &squares, const Series &series, const Design &design, const Prior &prior) {
    const double left = squares.without > 0 ? squares.with / squares.without : 1;
    const double log10_left =
        std::clamp(left > 0 ? std::log10(left) : period::kMinLogResidual, period::kMinLogResidual, 0.0);
    const period::Sampling sampling = sampling_of(series, design, detection_grid(series, prior));
    const double freedom = static_cast<double>(sampling.count - sampling.functions);
    const double z = freedom * (1 - left) / 2;
    return std::min(0.0, period::log10_fap(period::Fap::baluev, sampling, log10_left) +
                             std::log10(kShapes * std::max(z, 1.0)));
}

bool is_better_outside(const Squares &squares, const Series &series, const Design &design, const Prior &prior) {
    const double needed = squares.without - squares.with + kOutsideMargin;
    const double step = kOutsideStep / series.span, highest = 1 / (2 * median_step(series));
    ShapeWork work(series);
    const auto is_better = [&](double frequency) {
        return circular_pair(work.moments(series, design, {frequency, 0, 0})).gain() > needed;
    };
    for (double f = 5 * step; f < prior.frequency_min; f += step)
        if (is_better(f))
            return true;
    for (int i = 1; i < kMostOutside && prior.frequency_max + i * step < highest; i++)
        if (is_better(prior.frequency_max + i * step))
            return true;
    return false;
}

bool is_at_edge(const std::vector<PosteriorSample> &samples, const Orbit &best, const Prior &prior) {
    const auto is_near = [&](const PosteriorSample &sample) {
        const Orbit &orbit = sample.planet.orbit;
        return orbit.frequency < kNearEdge * prior.frequency_min || orbit.frequency > prior.frequency_max / kNearEdge ||
               orbit.eccentricity > 0.99 * prior.eccentricity_max;
    };
    const auto count = std::count_if(samples.begin(), samples.end(), is_near);
    return static_cast<double>(count) > kMostAtEdge * static_cast<double>(samples.size()) ||
           best.frequency < prior.frequency_min || best.frequency > prior.frequency_max;
}

bool is_too_heavy(const Units &units, const Series &series, const Planet &planet) {
    bool is_known = false;
    for (int star = 0; star < 2; star++) {
        if (!units.knows_mass(star) || (series.has_velocities() && star != planet.orbit.star))
            continue;
        is_known = true;
        const double mass = units.mass(star, 1 / planet.orbit.frequency, planet.orbit.eccentricity,
                                       orientation_of(series, planet).axis);
        if (mass < units.star_mass[star] * kEarthsPerSun)
            return false;
    }
    return is_known;
}

bool do_cross(const std::vector<PosteriorSample> &one, const std::vector<PosteriorSample> &other) {
    const size_t count = std::min(one.size(), other.size());
    size_t apart = 0;
    for (size_t i = 0; i < count; i++) {
        const Orbit &a = one[i].planet.orbit, &b = other[i].planet.orbit;
        const Orbit &inner = a.frequency > b.frequency ? a : b, &outer = a.frequency > b.frequency ? b : a;
        const double ratio = std::cbrt(std::pow(inner.frequency / outer.frequency, 2)); // of the semi-major axes
        apart += ratio * (1 - outer.eccentricity) > kLeastDistance * (1 + inner.eccentricity);
    }
    return static_cast<double>(apart) < kMostApart * static_cast<double>(count);
}

} // namespace toliman::planet
