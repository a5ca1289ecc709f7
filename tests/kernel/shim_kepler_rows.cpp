#include "kernels/kepler_rows.hpp"

using toliman::kernels::KeplerKernels;

namespace {

const KeplerKernels *kTables[] = {&toliman::kernels::kepler_baseline,
#if defined(__x86_64__)
                                  &toliman::kernels::kepler_avx2, &toliman::kernels::kepler_avx512
#endif
};

} // namespace

extern "C" {

int shim_kepler_tables() {
    return static_cast<int>(toliman::kernels::host_isa()) + 1;
}

size_t shim_kepler_lanes() {
    return toliman::kernels::kRowLanes;
}

void shim_kepler_rows(int table, int velocity, double frequency, double anomaly, double eccentricity, const double *t,
                      size_t n, double *x, double *y) {
    const KeplerKernels &kernel = *kTables[table];
    (velocity ? kernel.velocity : kernel.position)({frequency, anomaly, eccentricity}, t, n, x, y);
}

void shim_products(int table, const double *rows, size_t count, const double *x, const double *y, size_t n,
                   double *out) {
    kTables[table]->products(rows, count, x, y, n, out);
}
}
