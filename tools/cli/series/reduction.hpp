// Measured separations: their unit, their reduction to the orbit of the binary, and what is wrong with them.
#pragma once
#include "scenes/observer_options.hpp"
#include "series/series.hpp"

namespace cli {

// Unit of the values of a series: of an option, or of the file.
struct ValueUnit {
    std::string name;  // "" = unknown
    double factor = 0; // arcsec (velocities: m/s) per unit; 0 = unknown
    bool is_velocity = false;

    // A separation whose unit is known: results are also in microarcsec.
    bool in_uas() const noexcept { return factor > 0 && !is_velocity; }
};

// --plate-scale, --exposure, --on-target and the observer.
struct ReductionOptions {
    // needed: the option that all of them but --leap-seconds need; NULL for none.
    void add_to(CLI::App &command, CLI::Option *needed);
    // "--exposure 60", "--exposure not given".
    std::string exposures() const;
    void set(Json &json) const; // adds the observer, plate_scale_arcsec and exposure_s

    ObserverOptions observer;
    std::optional<double> plate_scale; // arcsec per px; separations in px. Otherwise they are in arcsec
    std::optional<double> exposure;    // s, whose middle is the time of a sample
    std::string on_target;             // table of windows; "": exposures without pauses
    bool of_folder = false;            // the frames have their own exposures
};

// The unit of this name, "" for none. plate_scale: arcsec per px.
ValueUnit unit_of(const std::string &name, const std::optional<double> &plate_scale);

// The unit of --unit, or that of the file if none is given. Failure if they differ.
ValueUnit unit_of(const std::string &option, const toliman_measure *series, const std::optional<double> &plate_scale);

// The unit of measured separations: px of --plate-scale, that of the file, or arcsec. Failure if they differ, and for
// velocities.
ValueUnit unit_of_separations(const toliman_measure *series, const ReductionOptions &options);

// How a series was reduced to the orbit.
struct ReductionNote {
    Json json;
    std::string text;
};

// A series of measured separations for the library, with their exposures. Throws Failure for bad options or times.
toliman::measurements separations_of(const toliman_measure *series, const ReductionOptions &options);

// Those for whose times the observer is known.
struct Reduced {
    toliman::measurements series;
    int64_t left_out;
};

// with_functions: as TOLIMAN_SKY_NO_FUNCTIONS is not set. Warns of samples that are left out, of exposures that
// overlap, and of a mean separation far from that of the orbit. Throws Failure for exposures that cannot be reduced,
// and if no sample is left.
Reduced reduce(const toliman_measure *measured, const ReductionOptions &options, const toliman_sky *sky,
               double scale_sigma, bool with_functions, Progress &progress);

// Replaces a series of measured separations by the reduced ones, with the functions that are fitted by default if
// with_functions.
ReductionNote reduce_to_orbit(const std::string &system, const ReductionOptions &options, double scale_sigma,
                              bool with_functions, toliman::measurements &series, Progress &progress);

// Throws Failure for a series that is reduced to an orbit refitted to it. name: of the series or option, cure: what to
// do.
void refuse_refitted(const toliman_measure *reduced, const std::string &name, const std::string &cure);

// If the chi-square about the orbit is poor and a wrong time scale, wrong axes or a wrong plate scale explain it, warns
// of that and returns it as JSON: cause, text, value, sigma, chi_square before and after, significance. Otherwise, and
// without sigmas, nothing.
std::optional<Json> diagnosis_of(const toliman_measure *measured, const toliman_sky *sky, double scale_sigma,
                                 Progress &progress);

} // namespace cli
