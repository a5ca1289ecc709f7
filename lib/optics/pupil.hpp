// The pupil: amplitude and optical path difference (OPD) of every cell.
#pragma once
#include "base/buffer.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

struct Pupil {
    size_t samples = 0;       // N
    Buffer<double> amplitude; // [N][N], open fraction of each cell times the amplitude that a file gives it
    Buffer<double> opd_m;     // [N][N], mask and aberrations
    double area = 0;          // that would let as much light through if it were open, in cells
};

Pupil make_pupil(const Scene &scene);

} // namespace toliman::optics
