// Normal equations of a weighted least-squares fit of images, row by row.
#pragma once
#include <cstddef>

#include "kernels/isa.hpp"

namespace toliman::kernels {

constexpr size_t kNormalLanes = 8; // partial sums of each element

inline double sum_of_lanes(const double *lane) noexcept {
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}

// How counts become electrons, and their variance.
struct CountModel {
    double e_per_count, bias, dark;
    double added_variance, floor; // electrons^2: beyond Poisson, least of all
    double limit;                 // electrons at which a pixel saturates
};

struct NormalKernels {
    // Given     counts [n]; light [n], expected photons; response [n], electrons per photon; blend: variances are
    //           those of (1 - blend) expected + blend counted electrons
    // Returned  weight [n] = response^2/variance and residual [n] = (electrons - expected)/response; pixels at the
    //           limit, or expected within 5 standard deviations of it, have weight 0, and their number is added to
    //           *saturated. Pixels without response have weight 0, but are not counted. *used: plus the others. False
    //           if a count is not finite
    bool (*weigh)(const double *counts, const double *light, const double *response, const CountModel &how,
                  double blend, size_t n, double *weight, double *residual, size_t *used, size_t *saturated) noexcept;

    // Given     weight, residual [n] as of weigh; tail, as frame/bad_pixels.hpp defines it, over the response
    // Returned  *square: the largest weight residual^2, and *excess: the largest weight residual (residual - tail),
    //           tail only where residual > 0; both at least their values before the call
    void (*largest)(const double *weight, const double *residual, double tail, size_t n, double *square,
                    double *excess) noexcept;

    // Given     lines[count], of n elements each; weight [n]; scratch [n]
    // Returned  sums[i][j][kNormalLanes] for j >= i, of [count][count]: plus sum over pixels of weight line_i line_j,
    //           distributed over the lanes
    void (*add)(const double *const *lines, size_t count, const double *weight, size_t n, double *scratch,
                double *sums) noexcept;

    // Given     weight, residual, light [n] as of weigh; predicted [n], photons of another model
    // Returned  weight: its square root; image [n] = sqrt(weight) (residual + light - predicted): the residual of that
    //           model over its sigma
    void (*whiten)(double *weight, const double *residual, const double *light, const double *predicted, size_t n,
                   double *image) noexcept;

    // Given     lines[count], root (of the weight), filter, scratch: of n elements each
    // Returned  sums[count + 1][kNormalLanes]: plus sum over pixels of root filter line_i; the last one plus filter^2
    //           over pixels of nonzero weight
    void (*correlate)(const double *const *lines, size_t count, const double *root, const double *filter, size_t n,
                      double *scratch, double *sums) noexcept;
};
TOLIMAN_ISA_DECLARE(NormalKernels, normal)

} // namespace toliman::kernels
