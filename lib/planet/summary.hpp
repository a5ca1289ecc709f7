// The posterior of a candidate in numbers: samples as rows, intervals, correlations.
#pragma once
#include <array>
#include <vector>

#include "planet/search.hpp"

namespace toliman::planet {

// Period, eccentricity, periastron in deg, epoch, amplitude, masses for stars A and B, jitter, inclination and node in
// deg. Angles and epochs are within half a turn of those of the best fit.
constexpr size_t kColumns = 10;
using Row = std::array<double, kColumns>;

Row row_of(const Result &result, const Candidate &candidate, const PosteriorSample &sample);

struct Summary {
    std::array<Interval, kColumns> intervals;
    std::array<double, kDescribed * kDescribed> correlation; // of the first columns
};
Summary summary_of(const Result &result, const Candidate &candidate);

// Jitter of the series itself: the largest of its instruments.
Interval jitter_of_series(const Result &result);

// Jitter of each instrument: with several, about the most probable of each.
std::vector<Interval> jitters_of(const Result &result);

} // namespace toliman::planet
