// Unit of the values of a series: of an option, or of the file.
#pragma once
#include <optional>
#include <string>

#include "series/reduction.hpp"
#include "series/series.hpp"

namespace cli {

struct ValueUnit {
    std::string name;  // "" = unknown
    double factor = 0; // arcsec (velocities: m/s) per unit; 0 = unknown
    bool is_velocity = false;

    // A separation whose unit is known: results are also in microarcsec.
    bool in_uas() const noexcept { return factor > 0 && !is_velocity; }
};

// The unit of this name, "" for none. plate_scale: arcsec per px.
ValueUnit unit_of(const std::string &name, const std::optional<double> &plate_scale);

// The unit of --unit, or that of the file if none is given. Failure if they differ.
ValueUnit unit_of(const std::string &option, const Series &series, const std::optional<double> &plate_scale);

// The unit of measured separations: px of --plate-scale, that of the file, or arcsec. Failure if they differ, and for
// velocities.
ValueUnit unit_of_separations(const Series &series, const ReductionOptions &options);

} // namespace cli
