// The OPD of each pupil cell from all frames together.
#pragma once
#include "calibrate/problem.hpp"

namespace toliman::calibrate {

struct MapOptions {
    double rms_m = 1e-8;      // of the prior
    int most_iterations = 60; // of the conjugate gradients
    double tolerance = 3e-3;  // of their residual, relative to the first one
};

// A Gauss-Newton step of the map, of the parameters of the frames and of those of the instrument that the map does not
// contain: all but Zernike polynomials and focus.
struct MapStep {
    Point change;          // of all parameters: 0 of those that the map contains; and of the map
    double chi_square = 0; // before the step, of all frames
    size_t used = 0;       // pixels
    int iterations = 0;    // of the conjugate gradients
    double residual = 0;   // theirs, relative to the first one
    double rms_m = 0;      // of the map's change, over the open pupil
    bool lost = false;     // a star left the model images: nothing else is valid
    bool solvable = false;
};

// All windows have the map in common. The result does not depend on the workers.
MapStep map_step(const Problem &problem, const Point &point, const MapOptions &options);

// The effective number of parameters of the map in one step: the trace of the matrix that gives the fitted frames from
// the given ones. Takes as long as a step. 0 if there is no solution.
double map_parameters(const Problem &problem, const Point &point, double rms_m);

} // namespace toliman::calibrate
