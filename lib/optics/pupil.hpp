// The pupil: amplitude and optical path difference (OPD) in each cell of a grid.
#pragma once
#include <vector>

#include "base/buffer.hpp"
#include "scene/scene.hpp"

namespace toliman::optics {

// A cell that an edge of the mask crosses.
struct MixedCell {
    size_t index;   // row * N + column
    double covered; // fraction of its area where the mask steps, in (0, 1)
};

struct Pupil {
    size_t samples = 0;           // N
    double aperture_m = 0;        // D, the width of the N cells
    Buffer<double> amplitude;     // [N][N], open fraction of each cell times the amplitude of the scene's file
    Buffer<double> opd_m;         // [N][N], mask and aberrations; in a mixed cell its mean over the area
    Buffer<double> defocus;       // [N][N], Noll's fourth polynomial; 0 where the amplitude is 0
    double area = 0;              // effective area in cells: a fully open area that transmits the same light
    std::vector<MixedCell> mixed; // open cells that edges of the mask cross, if the scene averages over their area
    double step_m = 0;            // of the mask
    double steepest_m = 0;        // largest change of the aberrations from an open cell to the next
};

double open_area_m2(const Pupil &pupil) noexcept; // the effective area

// The scene's pupil in samples x samples cells. Files must have exactly that many.
Pupil make_pupil(const Scene &scene, size_t samples);

// The map (m) of the scene's OPD file, [samples][samples]; empty without a file.
std::vector<double> opd_of_file(const Scene &scene, size_t samples);

// What a parameter changes in the pupil: an OPD, the covered fraction of cells by the mask, or the wavenumber.
struct Mode {
    struct Cell {
        size_t index;         // row * N + column
        double covered, rate; // fraction, and its derivative
    };
    bool of_wavenumber = false; // relative; all else is empty
    Buffer<double> opd_m;       // [N][N], OPD per unit; or empty, with
    std::vector<Cell> cells;    // those that the parameter changes
    double step_m = 0;          // of the mask
};

// OPD of 1 nm rms in Noll's polynomial `noll`.
Mode zernike_mode(const Pupil &pupil, int noll);

// Rotation of the mask by 1 deg, or its shift by 1 m along x or y. The scene's mask must be a spiral with
// Edges::area, and the pupil that of the scene. The covered areas are differentiated by central differences: 1e-3 of
// the largest.
enum class MaskMotion { rotation, shift_x, shift_y };
Mode mask_mode(const Scene &scene, const Pupil &pupil, MaskMotion motion);

// Derivative of the pupil field by a mode of cells or of the wavenumber (1/m), as amplitude and OPD [N][N], which must
// be 0 elsewhere.
void field_of(const Pupil &pupil, const Mode &mode, double wavenumber, double *amplitude, double *opd_m) noexcept;

// Every other cell in both axes, for estimates of images: the same pupil with cells twice as wide. The defocus is
// empty.
Pupil halved(const Pupil &pupil);

// Writes amplitude and OPD of the mixed cells at a wavenumber (1/m) into amplitude, opd_m [N][N]; others are unchanged.
void resolve_mixed(const Pupil &pupil, double wavenumber, double *amplitude, double *opd_m) noexcept;

} // namespace toliman::optics
