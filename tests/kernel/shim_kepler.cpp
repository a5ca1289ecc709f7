#include "isa_tables.hpp"
#include "kernels/kepler.hpp"
#include "kernels/kepler_rows.hpp"

extern "C" {

double shim_kepler(double mean_anomaly, double eccentricity) {
    return toliman::kernels::kepler(mean_anomaly, eccentricity);
}

size_t shim_kepler_lanes() {
    return toliman::kernels::kRowLanes;
}

void shim_kepler_rows(int isa, int velocity, double frequency, double anomaly, double eccentricity, const double *t,
                      size_t n, double *x, double *y) {
    const toliman::kernels::KeplerKernels &kernel = KERNELS(kepler, isa);
    (velocity ? kernel.velocity : kernel.position)({frequency, anomaly, eccentricity}, t, n, x, y);
}

void shim_products(int isa, const double *rows, size_t count, const double *x, const double *y, size_t n, double *out) {
    KERNELS(kepler, isa).products(rows, count, x, y, n, out);
}
}
