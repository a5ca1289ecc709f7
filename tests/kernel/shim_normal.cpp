// C interface of the normal equations.
#include "kernels/normal.hpp"

using namespace toliman::kernels;

namespace {

const NormalKernels &table(size_t isa) {
#if defined(__x86_64__)
    const NormalKernels *tables[] = {&normal_baseline, &normal_avx2, &normal_avx512};
    return *tables[isa];
#else
    (void)isa;
    return normal_baseline;
#endif
}

} // namespace

extern "C" {

size_t shim_isas(void) {
    return static_cast<size_t>(host_isa()) + 1;
}

// how: e_per_count, bias, dark, added_variance, floor, limit.
int shim_weigh(size_t isa, const double *counts, const double *light, const double *response, const double *how,
               double blend, size_t n, double *weight, double *residual, size_t *used, size_t *saturated) {
    const CountModel model = {how[0], how[1], how[2], how[3], how[4], how[5]};
    return table(isa).weigh(counts, light, response, model, blend, n, weight, residual, used, saturated);
}

void shim_normal_add(size_t isa, const double *const *lines, size_t count, const double *weight, size_t n,
                     double *scratch, double *sums) {
    table(isa).add(lines, count, weight, n, scratch, sums);
}

void shim_whiten(size_t isa, double *weight, const double *residual, const double *light, const double *predicted,
                 size_t n, double *image) {
    table(isa).whiten(weight, residual, light, predicted, n, image);
}

void shim_correlate(size_t isa, const double *const *lines, size_t count, const double *root, const double *filter,
                    size_t n, double *scratch, double *sums) {
    table(isa).correlate(lines, count, root, filter, n, scratch, sums);
}
}
