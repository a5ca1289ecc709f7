// Units of the columns of a table.
#pragma once
#include <string>
#include <string_view>

namespace toliman::ingest {

enum class Quantity { unknown, velocity, angle, pixels, time };

struct Unit {
    std::string name;                      // "m/s"; of an unknown unit its text; "" if none is stated
    Quantity quantity = Quantity::unknown; // of a unit that is known
    double factor = 0;                     // m/s, arcsec, px or days per unit; 0 if it is unknown
};

// The unit that a text states, in any of the usual forms: "m / s", "km s-1", "[mas]", "day".
Unit unit_of(std::string_view text);

// The factor from one unit to the other, 1 if one of them is not stated. 0: they cannot be converted.
double factor_between(const Unit &from, const Unit &to) noexcept;

} // namespace toliman::ingest
