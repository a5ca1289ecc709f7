// The relative response of each pixel from all frames together.
#pragma once
#include "calibrate/problem.hpp"

namespace toliman::calibrate {

struct ResponseOptions {
    double rms = 1e-2;         // of the prior, which is normal around the nominal response
    double still = 0.1;        // a shorter step gets the errors
    int most_iterations = 100; // of the conjugate gradients
    double tolerance = 1e-3;   // of their residual, relative to the right-hand side
};

// A Gauss-Newton step of the response, of the parameters of the frames and of those of the instrument.
struct ResponseStep {
    Point change; // of all, without an OPD map
    Buffer<double>
        sigma; // of the response of each pixel over the mean, all other parameters free; empty after a long step
    Buffer<double> covariance;      // that it adds to the parameters of the instrument, [n][n]; with sigma
    double separation_sigma_px = 0; // of the mean separation, due to the response and the instrument; with sigma
    double chi_square = 0;          // before the step, of all frames
    size_t used = 0;                // pixels
    // Of the step, in standard deviations: rms over the pixels, all else known; the largest of all other parameters,
    // the response known.
    double largest = 0;
    bool lost = false; // a star left the model images: nothing else is valid
    bool solvable = false;
};

// Of the only window. The result does not depend on the workers.
ResponseStep response_step(const Problem &problem, const Point &point, const ResponseOptions &options);

// The number of parameters that the frames determine: pixels minus the trace of the covariance over rms^2.
double response_parameters(const Buffer<double> &sigma, double rms) noexcept;

} // namespace toliman::calibrate
