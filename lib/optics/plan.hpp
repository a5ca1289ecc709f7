// The plan of a simulation, chosen from the scene's accuracy before any image is computed: wavelength nodes, expansion
// orders, pixel sampling, each with its predicted error; and the cost model.
#pragma once
#include "optics/light.hpp"
#include "optics/pixel.hpp"
#include "optics/pupil.hpp"
#include "scene/scene.hpp"

namespace toliman::optics {

enum class EngineKind { matrix_dft, padded_fft };

constexpr double kRounding = 1e-14;  // max error / peak of any image in double precision
constexpr size_t kCachedAnchors = 3; // those used last

// Sampling of the atlas (atlas.hpp).
struct AtlasPlan {
    size_t oversampling = 0; // samples per pixel and axis; 0 = the accuracy is beyond an atlas
    Blur blur;               // with the window of the interpolation
    PixelFilter filter;
    double error = 0;
};

// Errors are max error / peak of the image, against the image computed without that approximation.
struct Plan {
    EngineKind engine = EngineKind::matrix_dft;
    unsigned workers = 1;                   // threads of the simulation
    std::vector<double> plate_scale_errors; // of the engine at each wavelength, relative; empty = none
    Grid pixels = {};
    size_t scene_wavelengths = 0; // samples of the scene's spectra
    size_t wavelengths = 0;       // propagated: the same, or the number of nodes
    bool nodes = false;           // propagate Chebyshev nodes in 1/lambda instead of the scene's wavelengths
    double spectrum_error = 0;    // of the nodes
    bool exact_frames = false;    // every frame is propagated: a Taylor expansion is not worthwhile
    size_t order = 2;             // expansion order in the displacement
    double series_error = 0;      // of that expansion, relative to the signal's largest pixel, rounding included
    size_t place_order = 0;       // expansion order in both stars' positions; 0 = the positions are fixed
    double place_error = 0;       // of that expansion, relative to the signal, at 4 sigma
    double orbit_px = 0;          // upper bound of a star's motion along its orbit during the cadence
    size_t anchors = 0;           // expansion points along the orbit; 0 = one, at time 0
    double anchor_days = 0;       // time that each anchor covers
    double scale_focus_error = 0; // of scale to first order and focus to second order, at 4 sigma
    PixelFilter filter;
    AtlasPlan atlas;
    double pupil_error = 0; // of N pupil samples against infinitely many
};

// Cost of a plan: the set-up (all images, once) and each frame. Seconds are those of one core.
struct Cost {
    double setup_flops = 0, frame_flops = 0;
    double bytes = 0; // memory, all workers together
    double setup_s = 0, frame_s = 0;
};

Cost cost_of(const Scene &scene, const Pupil &pupil, const Plan &plan);

// The detector's pixels.
Grid grid_of(const Detector &detector) noexcept;

// Chooses the plan. Status::scene or Status::unsupported if the frame would show aliases, or the engine cannot model
// it.
Plan make_plan(const Scene &scene, const Pupil &pupil, const Light &light, EngineKind engine, unsigned workers);

// The plan with wavelengths for the accuracy of `scene`, all else as it is.
Plan with_accurate_spectrum(Plan plan, const Scene &scene, const Pupil &pupil, const Light &light);

} // namespace toliman::optics
