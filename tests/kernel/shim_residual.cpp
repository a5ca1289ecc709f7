// C interface of the residual kernels.
#include "kernels/residual.hpp"

using toliman::kernels::ResidualKernels;

namespace {

const ResidualKernels &table(int isa) {
#if defined(__x86_64__)
    const ResidualKernels *tables[] = {&toliman::kernels::residual_baseline, &toliman::kernels::residual_avx2,
                                       &toliman::kernels::residual_avx512};
    return *tables[isa];
#else
    (void)isa;
    return toliman::kernels::residual_baseline;
#endif
}

} // namespace

extern "C" int shim_residual_isas(void) {
    return static_cast<int>(toliman::kernels::host_isa()) + 1;
}

extern "C" int shim_residual(int isa, const double *counts, const double *reference, const double *inverse_sigma,
                             size_t count, double *out) {
    return table(isa).residual(counts, reference, inverse_sigma, count, out) ? 1 : 0;
}

extern "C" int shim_scaled_residual(int isa, const double *counts, const double *reference, const double *inverse_sigma,
                                    double scale, size_t count, float *out) {
    return table(isa).scaled_residual(counts, reference, inverse_sigma, scale, count, out) ? 1 : 0;
}

extern "C" void shim_residual_project(int isa, const double *units, size_t planes, size_t count, double *vector) {
    table(isa).project_out(units, planes, count, vector);
}

// The vectors and rows of `frames` frames follow each other.
extern "C" int shim_project_rows(int isa, const size_t *rows_cols_planes, size_t frames, const double *counts,
                                 const double *reference, const double *inverse_sigma, const float *basis, double scale,
                                 float *vectors, float *out) {
    const toliman::kernels::ProjectedRows rows = {
        rows_cols_planes[0], rows_cols_planes[1], rows_cols_planes[2], reference, inverse_sigma, basis, scale};
    const size_t pixels = rows.rows * rows.cols;
    float component[8][toliman::kernels::kMaxPlanes], *components[8], *vector[8], *row[8];
    const double *frame[8];
    for (size_t f = 0; f < frames; f++) {
        components[f] = component[f];
        vector[f] = vectors + f * pixels;
        frame[f] = counts + f * pixels;
    }
    if (!table(isa).components(rows, frames, frame, rows.cols, vector, components))
        return 0;
    for (size_t r = 0; r < rows.rows; r++) {
        for (size_t f = 0; f < frames; f++)
            row[f] = out + f * pixels + r * rows.cols;
        table(isa).project_row(rows, frames, components, r, vector, row);
    }
    return 1;
}

extern "C" double shim_residual_inner(int isa, const double *a, const double *b, size_t count) {
    return table(isa).inner(a, b, count);
}

extern "C" double shim_magnitude(int isa, const double *residual, size_t count, double most) {
    return table(isa).magnitude(residual, count, most);
}

extern "C" float shim_magnitude_float(int isa, const float *residual, size_t count, float most) {
    return table(isa).magnitude_float(residual, count, most);
}

extern "C" double shim_residual_inner_float(int isa, const float *a, const float *b, size_t count) {
    return table(isa).inner_float(a, b, count);
}
