// Calibration: the instrument's parameters, and the OPD of each pupil cell, from many frames together.
#pragma once
#include <functional>
#include <string>

#include "calibrate/solve.hpp"

namespace toliman::calibrate {

enum Verdict : uint32_t { not_converged = 1, incomplete = 2, held = 4, no_sign = 8 };

constexpr double kStructureLimit = 50; // of `structure`
constexpr double kHeld = 0.7;          // of the prior's standard deviation: above it, the prior determines a parameter

struct Calibration {
    Scene nominal;
    std::vector<Free> free;
    std::vector<double> first_days;           // of the windows
    std::vector<std::vector<size_t>> windows; // their frames
    Point point;
    Uncertainty uncertainty;
    std::vector<fit::Result> frames;       // of each frame
    std::vector<double> chi_square_of;     // of each window, per degree of freedom
    std::vector<bool> even;                // parameters without a sign
    Buffer<double> amplitude;              // of the nominal pupil, [N][N]
    std::vector<double> nominal_map_m;     // of the nominal scene's OPD file, [N][N]; empty without one
    Buffer<double> before, after, chi_map; // [rows][cols]: whitened residuals of frame 0; mean squares of all
    size_t samples = 0;                    // N
    uint32_t flags = 0;
    bool underway = false; // has no uncertainty yet
    int iterations = 0, map_iterations = 0;
    double chi_square = 0, chi_square_sigma = 0, structure = 0, structure_limit = kStructureLimit;
    double separation_sigma_px = 0, calibration_sigma_px = 0, map_rms_m = 0;
};

struct Report {
    bool of_map = false, accepted = false;
    int iteration = 0;
    double chi_square = 0, largest_step = 0;
};

struct Options {
    int most_iterations = 30;
    bool map = false;
    double map_rms_m = 1e-8;
    // Called after each iteration on the caller's thread; it may throw to cancel.
    std::function<void(const Calibration &so_far, const Report &report)> on_step;
};

// From a start of the instrument, the same in all windows; its frames are found first.
Calibration calibrate(const Problem &problem, const std::vector<double> &start, const Buffer<double> &map_m,
                      const Options &options);

// The fitted scene of a window.
Scene fitted_scene(const Calibration &calibration, size_t window);

// The change of the OPD (m) in a window against the nominal scene, [N][N].
Buffer<double> opd_change(const Calibration &calibration, size_t window);

} // namespace toliman::calibrate
