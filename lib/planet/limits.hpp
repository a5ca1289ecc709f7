// Limits of one planet more than those that a search found.
#pragma once
#include <vector>

#include "planet/recovery.hpp"
#include "planet/search.hpp"

namespace toliman::planet {

struct Limit {
    double period;
    double upper, detectable; // amplitudes
    double upper_mass_a, upper_mass_b, detectable_mass_a, detectable_mass_b;
};

// Status::argument for a period outside the prior.
std::vector<Limit> limits_of(const Result &result, const Recovery &recovery, const std::vector<double> &periods,
                             double probability);

// Status::argument, naming the member, for a cell outside the prior, and for sizes that are not known.
void check(const Result &result, const InjectionCell &cell);

} // namespace toliman::planet
