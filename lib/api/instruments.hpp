// Instruments of a fit, as of measure.h.
#pragma once
#include <string>
#include <vector>

#include <toliman/measure.h>

#include "api/output.hpp"
#include "planet/instruments.hpp"

namespace toliman::api {

// names: of each.
void write_instruments(const std::vector<planet::Instrument> &all, const std::vector<std::string> &names,
                       const StructOutput<toliman_measure_instrument> &out);

} // namespace toliman::api
