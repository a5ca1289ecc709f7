// What a tracker is asked for, and how its estimator and its folder complete it.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "track/tracker.hpp"

namespace toliman::track {

// An estimator and its properties.
struct Source {
    size_t rows = 0, cols = 0; // of the input image; 0: any
    double sigma = 0;          // standard deviation of a value; 0: unknown
    uint64_t digest = 0;       // identity of the estimator
    std::string values;        // names of its further values (base/words.hpp)
    Estimate estimate;
    double scale_arcsec = 0; // of a pixel; 0: unknown
    ModelVerdict model = {};
    std::string parameters = {}; // names of the parameters that it fits
};

// The reference orbit of a reduction.
struct Orbit {
    std::string system; // JSON text
    bool in_orbit = false;
    Reduce reduce;
    // Adds the errors of the orbit to the columns of the sums.
    std::function<void(double scale_sigma, period::Basis &basis, OrbitErrors &errors)> add_errors;
};

constexpr double kLimitOfMedian = -1; // chi_limit

// Members that are 0 or empty are those of the folder.
struct Request {
    std::optional<period::Grid> grid; // without functions
    std::optional<Clock> clock;
    std::optional<Stamp> stamp;
    double exposure_s = 0;
    double scale_arcsec = 0, scale_sigma = 0;
    double chi_limit = 0;                  // kLimitOfMedian: that of the median
    int32_t trend = 0;                     // -1: no functions
    double trend_start = 0, trend_end = 0; // both 0: from the frequency step
    const char *folder = nullptr;          // of the frames
    const char *setup_folder = nullptr;    // whose setup a new folder gets
    bool has_estimator = false;            // frames can be pushed
    // The orbit, whose system is that of the folder if it has the same numbers; empty: frames are not reduced.
    std::function<Orbit(const std::string &system)> orbit;
};

// Completes sides, sigma and limit of the values. reduced: whether the values are. Status::argument, naming the option.
Terms completed(Terms terms, const Source &source, bool reduced);

// The columns of a new ledger. An estimator of the library has values of its own. Status::argument for other ones.
Columns columns_of(const std::string &values, const Source &source, bool reduced);

// The parameters in the ledger of a folder, for a new one without an estimator; "" without a ledger.
std::string parameters_in(const char *folder);

// The setup of a tracker. orbit: becomes that of the request. Status::argument, naming the option, if it must be given;
// Status::mismatch and Status::format for the setup of another folder.
Setup setup_of(const Request &request, const Source &source, const Terms &terms, const StateFolder &place,
               Orbit &orbit);

} // namespace toliman::track
