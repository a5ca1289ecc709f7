// The pupil: grey-edged amplitude of the aperture and the mask's optical path difference.
#pragma once
#include "base/buffer.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

struct Pupil {
    size_t samples = 0;       // N
    double aperture_m = 0;    // D, the width of the N cells
    Buffer<double> amplitude; // [N][N], open fraction of each cell
    Buffer<double> opd_m;     // [N][N]
    double area = 0;          // sum of the amplitude, in cells
};

Pupil make_pupil(const Scene &scene);

} // namespace toliman::optics
