// C interface of the normal equations.
#include "isa_tables.hpp"
#include "kernels/normal.hpp"

using namespace toliman::kernels;

extern "C" {

// how: e_per_count, bias, dark, added_variance, floor, limit.
int shim_weigh(int isa, const double *counts, const double *light, const double *response, const double *how,
               double blend, size_t n, double *weight, double *residual, size_t *used, size_t *saturated) {
    const CountModel model = {how[0], how[1], how[2], how[3], how[4], how[5]};
    return KERNELS(normal, isa).weigh(counts, light, response, model, blend, n, weight, residual, used, saturated);
}

void shim_normal_add(int isa, const double *const *lines, size_t count, const double *weight, size_t n, double *scratch,
                     double *sums) {
    KERNELS(normal, isa).add(lines, count, weight, n, scratch, sums);
}

void shim_whiten(int isa, double *weight, const double *residual, const double *light, const double *predicted,
                 size_t n, double *image) {
    KERNELS(normal, isa).whiten(weight, residual, light, predicted, n, image);
}

void shim_correlate(int isa, const double *const *lines, size_t count, const double *root, const double *filter,
                    size_t n, double *scratch, double *sums) {
    KERNELS(normal, isa).correlate(lines, count, root, filter, n, scratch, sums);
}
}
