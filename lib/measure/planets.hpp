// A series as the search for planets takes it.
#pragma once
#include <string>
#include <vector>

#include "measure/series.hpp"
#include "planet/mass.hpp"
#include "planet/series.hpp"

namespace toliman::measure {

// name: of the series, in messages.
planet::GivenSeries given_of(const Series &series, const char *name);

// Adds the velocities of a star of a series, in the times of the series. Status::argument, naming the velocities, if
// kind, units or times do not allow it.
void add_velocities(const Series &series, const planet::Units &units, const Series &own, size_t star, const char *name,
                    planet::GivenVelocities &velocities);

// Adds the names of the instruments; "" for the only one.
void add_names(const Series &series, std::vector<std::string> &names);

} // namespace toliman::measure
