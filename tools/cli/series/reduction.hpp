// Reduces a series of measured separations to the orbit of its binary.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "scenes/observer_options.hpp"
#include "series/series.hpp"

namespace CLI {
class Option;
}

namespace cli {

// --plate-scale, --exposure and the observer.
struct ReductionOptions {
    // needed: the option that all of them but --leap-seconds need; NULL for none.
    void add_to(CLI::App &command, CLI::Option *needed);
    void set(Json &json) const; // adds the observer, plate_scale_arcsec and exposure_s

    ObserverOptions observer;
    std::optional<double> plate_scale; // arcsec per px; separations in px. Otherwise they are in arcsec
    std::optional<double> exposure;    // s, whose middle is the time of a sample
};

// How a series was reduced to the orbit.
struct ReductionNote {
    Json json;
    std::string text;
};

// Measured separations and their exposures.
struct Measured {
    Series series;                  // t, y and sigma
    std::vector<int64_t> intervals; // [n][2], start and end of the exposures, TAI ns
    double plate_scale;             // arcsec per unit of y
    std::string exposures;          // the option that states the length of all of them; "": each has its own
};
// The samples of a series. Throws Failure for bad options or times.
Measured measured_of(const Series &series, const ReductionOptions &options);

// Those for whose times the observer is known.
struct Measurements {
    Series reduced; // with its columns; y and sigma of the reduced separations, in the unit of the series
    std::vector<int64_t> intervals;          // [n][2], start and end of the exposures, TAI ns
    std::vector<double> separations, sigmas; // measured, arcsec; sigmas as Series
    std::vector<toliman_sky_prediction> predictions;
    size_t unreduced; // samples that were left out
};

// Warns of samples that are left out. Throws Failure for exposures that cannot be reduced, and if no sample is left.
Measurements reduce(const Measured &measured, const ReductionOptions &options, const toliman_sky *sky,
                    Progress &progress);

} // namespace cli
