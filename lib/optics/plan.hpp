// What a scene needs, decided from its accuracy before any image is made: wavelengths, terms of the series, samples of
// a pixel; and the error that each choice is expected to leave.
#pragma once
#include "optics/light.hpp"
#include "optics/pixel.hpp"
#include "optics/pupil.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

enum class EngineKind { matrix_dft, padded_fft };

constexpr double kRounding = 1e-14; // max error / peak of any image in double
constexpr size_t kKeptAnchors = 3;  // the last used

// Errors are max error / peak, against the scene computed without that choice.
struct Plan {
    EngineKind engine = EngineKind::matrix_dft;
    unsigned workers = 1;                   // that carry it out
    std::vector<double> plate_scale_errors; // of the engine at each wavelength, relative; empty = none
    Grid pixels = {};
    size_t scene_wavelengths = 0; // of the scene
    size_t wavelengths = 0;       // that are propagated
    bool nodes = false;           // they are Chebyshev nodes, fewer than the scene's
    double spectrum_error = 0;
    bool exact_frames = false;    // every frame is propagated: the signal is too large for the series
    size_t order = 2;             // of the series in the displacement
    double series_error = 0;      // relative to the signal's own largest pixel, rounding included
    size_t place_order = 0;       // of the series in both stars' places; 0 = nothing moves them
    double place_error = 0;       // relative to the signal, at 4 sigma
    double orbit_px = 0;          // that a star moves along its orbit in the cadence, at most
    size_t anchors = 0;           // places along the orbit about which series are made; 0 = one, at time 0
    double anchor_days = 0;       // that each of them serves
    double scale_focus_error = 0; // of the scale to first order and the focus to second, at 4 sigma
    PixelFilter filter;
    double pupil_error = 0; // of N samples against many
};

// What carrying a plan out takes: all images once, and then each frame; seconds are those of one core.
struct Cost {
    double setup_flops = 0, frame_flops = 0;
    double bytes = 0; // of memory, on all workers
    double setup_s = 0, frame_s = 0;
};

Cost cost_of(const Scene &scene, const Pupil &pupil, const Plan &plan);

Plan make_plan(const Scene &scene, const Pupil &pupil, const Light &light, EngineKind engine, unsigned workers);

} // namespace toliman::optics
