// The plan of a simulation, chosen from the scene's accuracy before any image is computed: wavelength nodes, expansion
// order, sampling of pixels and of the atlas, each with its predicted error.
#pragma once
#include "optics/half_band.hpp"
#include "optics/light.hpp"
#include "optics/pixel.hpp"
#include "optics/pupil.hpp"
#include "scene/scene.hpp"

namespace toliman::optics {

enum class EngineKind { matrix_dft, padded_fft };

// How the expected image of a frame is made.
enum class Frames {
    series,      // by the Taylor expansion in the displacement
    atlas,       // interpolated at the places of the stars
    propagation, // each propagated
};

constexpr double kRounding = 1e-14; // max error / peak of any image in double precision

// Sampling of the atlas (atlas.hpp).
struct AtlasPlan {
    size_t oversampling = 0; // samples per pixel and axis; 0 = the accuracy is beyond an atlas
    double cutoff = 0;       // highest frequency of an image, in cycles per sample
    HalfBand half_band;      // not empty: every other sample is propagated
    Blur blur;               // with the window of the interpolation
    PixelFilter filter, smear_filter;
    double error = 0;   // also of slopes, relative to the largest slope
    Offsets reach = {}; // largest |x| and |y| of the stars in the scene's frames, px
};

// Errors are max error / peak of the image, against the image computed without that approximation.
struct Plan {
    EngineKind engine = EngineKind::matrix_dft;
    unsigned workers = 1;                   // threads of the simulation
    size_t fft_side = 0;                    // N_out of the padded FFT; 0 = another engine
    size_t fft_cells[2] = {};               // its N_E at the longest and the shortest wavelength
    std::vector<double> plate_scale_errors; // of the engine at each wavelength, relative; empty = none
    Grid pixels = {};
    size_t scene_wavelengths = 0; // samples of the scene's spectra
    size_t wavelengths = 0;       // propagated: the same, or the number of nodes
    bool nodes = false;           // propagate Chebyshev nodes in 1/lambda instead of the scene's wavelengths
    double spectrum_error = 0;    // of the nodes
    Frames frames = Frames::series;
    size_t order = 2;        // expansion order in the displacement
    double series_error = 0; // of that expansion, relative to the signal's largest pixel, rounding included
    double orbit_px = 0;     // upper bound of a star's motion along its orbit during the cadence
    HalfBand half_band;      // of the samples of the filter: not empty: every other one is propagated
    PixelFilter filter;
    PixelFilter smear_filter; // of second derivatives along the path, for the derivative by smear; empty without one
    AtlasPlan atlas;
    double pupil_error = 0; // of N pupil samples against infinitely many
};

// The detector's pixels.
Grid grid_of(const Detector &detector) noexcept;

// The samples of the atlas for a star at most `reach` px [x, y] from the centre of the frame; the star is at their
// centre, on a sample.
Grid atlas_grid(const Plan &plan, const std::array<double, 2> &reach) noexcept;

// Chooses the plan. Status::scene or Status::unsupported if the frame would show aliases, or the engine cannot model
// it.
Plan make_plan(const Scene &scene, const Pupil &pupil, const Light &light, EngineKind engine, unsigned workers);

// The plan with wavelengths for the accuracy of `scene`, all else as it is.
Plan with_accurate_spectrum(Plan plan, const Scene &scene, const Pupil &pupil, const Light &light);

} // namespace toliman::optics
