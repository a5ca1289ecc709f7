// A star alone in the centre of the frame behind a scene's telescope.
#pragma once
#include <vector>

#include "common/json.hpp"
#include "scenes/scene.hpp"

namespace cli {

struct SingleStar {
    double min_nm, max_nm; // band in steps of about 1 nm, at most 1000 steps; equal: one wavelength
    size_t side;           // rows and columns of the frame
    double pixel_scale_arcsec;
    double amplitude_px; // of the signal along the rows; 0 = none
    double accuracy;
};

// A black body of 5790 K, seen by point-sampling pixels without noise. `telescope` is that of a scene whose file names
// are relative to the folder of `path`. Throws toliman::error with TOLIMAN_E_SCENE if the pupil has too few samples.
Scene single_star(const std::string &path, const cJSON *telescope, const SingleStar &star);

// Fraction of the star's light in each pixel of its frame without displacement.
std::vector<double> light_fractions(const Scene &star);
// The same for a displacement in px: exact, or by the Taylor expansion that frames are made with.
std::vector<double> light_fractions(const Scene &star, double displacement_px, bool exact);

} // namespace cli
