#include "series/value_unit.hpp"

#include <map>

#include "common/failure.hpp"
#include "scenes/observer_options.hpp"

namespace cli {

namespace {

const std::map<std::string, ValueUnit> &known_units() {
    static const std::map<std::string, ValueUnit> units = {{"", {}},
                                                           {"arcsec", {"arcsec", 1, false}},
                                                           {"mas", {"mas", 1e-3, false}},
                                                           {"uas", {"uas", 1e-6, false}},
                                                           {"deg", {"deg", 3600, false}},
                                                           {"px", {"px", 0, false}},
                                                           {"m/s", {"m/s", 1, true}},
                                                           {"km/s", {"km/s", 1000, true}},
                                                           {"cm/s", {"cm/s", 1e-2, true}}};
    return units;
}

// Whether the file states a unit that has a factor.
bool states_unit(const Series &series) {
    return !series.unit_name.empty() && known_units().count(series.unit_name) > 0;
}

} // namespace

ValueUnit unit_of(const std::string &name, const std::optional<double> &plate_scale) {
    ValueUnit unit = known_units().at(name);
    if (name == "px" && !plate_scale)
        throw Failure(kExitUsage, "--unit px: needs --plate-scale");
    if (name == "px")
        unit.factor = plate_scale_of(plate_scale, 1);
    else if (plate_scale)
        throw Failure(kExitUsage, "--plate-scale: needs --unit px, --system or a state folder");
    return unit;
}

ValueUnit unit_of(const std::string &option, const Series &series, const std::optional<double> &plate_scale) {
    const bool stated = states_unit(series);
    if (stated && !option.empty() && option != series.unit_name)
        throw Failure(kExitUsage, "--unit " + option + ": " + series.name + " states that y is in " + series.unit_name);
    const bool needs_scale = series.unit_name == "px" && !plate_scale;
    return unit_of(stated && option.empty() && !needs_scale ? series.unit_name : option, plate_scale);
}

ValueUnit unit_of_separations(const Series &series, const ReductionOptions &options) {
    const bool stated = states_unit(series);
    if (!stated || (series.unit_name == "px" && options.plate_scale))
        return unit_of(options.plate_scale ? "px" : "arcsec", options.plate_scale);
    if (known_units().at(series.unit_name).is_velocity)
        malformed(series.name, "y is in " + series.unit_name + ": must be measured separations");
    if (series.unit_name == "px" || options.plate_scale)
        throw Failure(kExitUsage, std::string("--plate-scale: ") +
                                      (options.plate_scale ? "must not be given: " : "must be given: ") + series.name +
                                      " states that y is in " + series.unit_name);
    return unit_of(series.unit_name, std::nullopt);
}

} // namespace cli
