// Whether a candidate is a planet: reasons against it.
#pragma once
#include <cstdint>
#include <vector>

#include "planet/lattice.hpp"
#include "planet/mass.hpp"
#include "planet/posterior.hpp"

namespace toliman::planet {

// In the order of TOLIMAN_PLANET_REASON_....
enum Reason : uint32_t {
    kReasonOdds = 1u << 16,
    kReasonChiSquare = 1u << 17,
    kReasonJitter = 1u << 18,
    kReasonFap = 1u << 19,
    kReasonEdge = 1u << 20,
    kReasonRange = 1u << 21,
    kReasonMass = 1u << 22,
    kReasonCrossing = 1u << 23,
    kReasonFrames = 1u << 24,
    kReasonSamples = 1u << 25,
    kReasonEvidence = 1u << 26
};
constexpr uint32_t reason_if(bool is_true, Reason reason) noexcept {
    return is_true ? static_cast<uint32_t>(reason) : 0;
}

// Median chi-square of the frames, beyond which their model lacks an effect, whose sizes and periods are unknown.
constexpr double kMostFrameChiSquare = 2;

// What the functions of a problem and an orbit leave: sums of squares over the variances of the fit.
struct Squares {
    double without, with;
};

// log10 of the false alarm probability of the squares of a fitted orbit: Baluev's bound for a sinusoid of this power,
// times the number of shapes that an orbit of one period may have.
double log10_fap_of_orbit(const Squares &squares, const Series &series, const Design &design, const Prior &prior);

// Whether a sinusoid of a period outside the prior takes more from the sum of squares than the orbit does. design: of
// the functions and values without the orbit.
bool is_better_outside(const Squares &squares, const Series &series, const Design &design, const Prior &prior);

constexpr double kNearEdge = 1.01, kMostAtEdge = 0.01;
// Whether more than 1 % of the posterior, or the best fit, is within 1 % of an end of the prior, or outside.
bool is_at_edge(const std::vector<PosteriorSample> &samples, const Orbit &best, const Prior &prior);

// Whether the mass of a planet is at least that of its star, for each star of known mass that may have it.
bool is_too_heavy(const Units &units, const Series &series, const Planet &planet);

// Whether the orbits of two planets of one star cross, in all but 5 % of the pairs of samples.
bool do_cross(const std::vector<PosteriorSample> &one, const std::vector<PosteriorSample> &other);

} // namespace toliman::planet
