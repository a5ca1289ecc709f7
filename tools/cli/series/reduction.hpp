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
    // "--exposure 60", "--exposure not given".
    std::string exposures() const;
    void set(Json &json) const; // adds the observer, plate_scale_arcsec and exposure_s

    ObserverOptions observer;
    std::optional<double> plate_scale; // arcsec per px; separations in px. Otherwise they are in arcsec
    std::optional<double> exposure;    // s, whose middle is the time of a sample
    bool of_folder = false;            // the frames have their own exposures
};

// How a series was reduced to the orbit.
struct ReductionNote {
    Json json;
    std::string text;
};

// A series of measured separations for the library, with their exposures. Throws Failure for bad options or times.
toliman::measurements separations_of(const Series &series, const ReductionOptions &options);

// Those for whose times the observer is known.
struct Reduced {
    toliman::measurements measure;
    Series series; // the same for the program
    int64_t left_out;
};

// name: of the series in messages. with_functions: as TOLIMAN_SKY_NO_FUNCTIONS is not set. Warns of samples that are
// left out, of exposures that overlap, and of a mean separation far from that of the orbit. Throws Failure for
// exposures that cannot be reduced, and if no sample is left.
Reduced reduce(const toliman_measure *measured, const std::string &name, const ReductionOptions &options,
               const toliman_sky *sky, double scale_sigma, bool with_functions, Progress &progress);

// Replaces a series of measured separations by the reduced ones, with the functions that are fitted by default if
// with_functions.
ReductionNote reduce_to_orbit(const std::string &system, const ReductionOptions &options, double scale_sigma,
                              bool with_functions, Series &series, Progress &progress);

} // namespace cli
