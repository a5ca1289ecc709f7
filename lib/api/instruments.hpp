// Instruments of a fit, as of measure.h.
#pragma once
#include <array>
#include <string>
#include <vector>

#include <toliman/measure.h>

#include "planet/design.hpp"

namespace toliman::api {

// jitters: 16, 50 and 84 % of each; names: of each. design: of the functions of the series, and others after them.
std::vector<toliman_measure_instrument> public_instruments(const planet::Series &series, const planet::Design &design,
                                                           const std::vector<std::array<double, 3>> &jitters,
                                                           const std::vector<std::string> &names);

} // namespace toliman::api
