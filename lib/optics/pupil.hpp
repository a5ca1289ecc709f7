// The pupil: amplitude and optical path difference (OPD) of every cell.
#pragma once
#include "base/buffer.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

struct Pupil {
    size_t samples = 0;       // N
    double aperture_m = 0;    // D, the width of the N cells
    Buffer<double> amplitude; // [N][N], open fraction of each cell times the amplitude that a file gives it
    Buffer<double> opd_m;     // [N][N], mask and aberrations
    Buffer<double> defocus;   // [N][N], Noll's fourth polynomial where there is light
    double area = 0;          // that would let as much light through if it were open, in cells
};

// The scene's pupil in samples x samples cells. Files give it cell by cell: they allow no other number than theirs.
Pupil make_pupil(const Scene &scene, size_t samples);

} // namespace toliman::optics
