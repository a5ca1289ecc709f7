// Calibration: the instrument's parameters, and the OPD of each pupil cell, from many frames together.
#pragma once
#include <functional>
#include <limits>
#include <string>

#include "base/goodness.hpp"
#include "calibrate/solve.hpp"

namespace toliman::calibrate {

enum Verdict : uint32_t { not_converged = 1, incomplete = 2, held = 4, no_sign = 8, too_good = 16 };

constexpr double kStructureLimit = 50; // of `structure`
constexpr double kHeld = 0.7;          // of the prior's standard deviation: above it, the prior determines a parameter

// What an incomplete model may lack, in the order in which it is tried.
// In the order of TOLIMAN_CALIBRATION_CHANGE_....
enum Lack : uint32_t {
    lacks_edges = 1u << 11,
    lacks_samples = 1u << 12,
    lacks_spectrum = 1u << 13,
    lacks_drift = 1u << 14,
    lacks_map = 1u << 15
};

// A calibration with one change of the model.
struct Attempt {
    Lack lack;
    bool kept;
    uint32_t flags;
    size_t samples;
    Goodness goodness;
};

struct Calibration {
    Scene nominal;
    std::vector<Free> free;
    std::vector<double> first_days;           // starts of the windows
    std::vector<std::vector<size_t>> windows; // their frames
    Point point;
    Uncertainty uncertainty;
    std::vector<fit::Result> frames;       // of each frame
    std::vector<Goodness> goodness_of;     // of each window; without frames, that of the one before
    std::vector<bool> even;                // parameters without a sign
    Buffer<double> amplitude;              // of the nominal pupil, [N][N]
    std::vector<double> nominal_map_m;     // of the nominal scene's OPD file, [N][N]; empty without one
    Buffer<double> before, after, chi_map; // [rows][cols]: whitened residuals of frame 0; mean squares of all
    size_t samples = 0;                    // N
    uint32_t flags = 0;
    bool underway = false; // has no uncertainty yet
    int iterations = 0, map_iterations = 0, response_iterations = 0;
    Goodness goodness;
    double squares = 0, freedom = 0; // sum of squared residuals over their variances; degrees of freedom
    double structure = 0, structure_limit = kStructureLimit;
    double separation_sigma_px = 0, calibration_sigma_px = 0, map_rms_m = 0;
    double map_parameters = 0;                        // effective number, of the map
    Buffer<double> response_sigma;                    // of the relative change of each pixel; empty: not fitted
    double response_rms = 0, response_parameters = 0; // of the prior; number that the frames determine
    double pupil_error = 0, peak_noise = 0; // of the plan; of the brightest pixel in all frames together, relative
    std::vector<LeftOut> left_out;
    std::vector<Attempt> attempts; // to improve the model
    double drift = 0;              // share of what is not noise that values may explain which change (more) with time
    uint32_t lacks = 0, improved = 0; // Lack, of an incomplete model; of the attempts that were kept

    // Whether it converged and is finished; otherwise it has no errors, and no values that depend on them.
    bool has_values() const noexcept { return (flags & not_converged) == 0 && !underway; }
    // Covariance of two parameters at the start of a window; NaN without values.
    double covariance(size_t window, size_t i, size_t j) const noexcept {
        const size_t n = free.size(), size = n * windows.size();
        return has_values() ? uncertainty.instrument[(window * n + i) * size + window * n + j]
                            : std::numeric_limits<double>::quiet_NaN();
    }
};

struct Report {
    bool of_map = false, of_response = false, accepted = false, recalled = false; // recalled: from the journal
    int iteration = 0;
    double chi_square = 0, largest_step = 0;
    uint32_t lack = 0; // that the attempt adds; 0 = the model as given
};

struct Options {
    int most_iterations = 30;
    bool map = false;
    double map_rms_m = 1e-8;
    bool response = false;
    double response_rms = 1e-2;
    uint32_t lack = 0, improved = 0; // Lack: of the attempt; all that the nominal scene and the parameters were given
    // Called after each iteration on the caller's thread; it may throw to cancel.
    std::function<void(const Calibration &so_far, const Report &report)> on_step;
};

// From a start, whose frames are found first if it has none.
Calibration calibrate(const Problem &problem, const Point &start, const Options &options);

// The fitted scene at the start of a window.
Scene fitted_scene(const Calibration &calibration, size_t window);

// The response [rows][cols] of the fitted scene; empty if neither it nor the nominal one has any.
std::vector<double> fitted_response(const Calibration &calibration);

// The change of the OPD (m) at the start of a window against the nominal scene, [N][N].
Buffer<double> opd_change(const Calibration &calibration, size_t window);

} // namespace toliman::calibrate
