// C interface of the residual kernels.
#include "isa_tables.hpp"
#include "kernels/residual.hpp"

extern "C" int shim_residual(int isa, const double *counts, const double *reference, const double *inverse_sigma,
                             size_t count, double *out) {
    return KERNELS(residual, isa).residual(counts, reference, inverse_sigma, count, out) ? 1 : 0;
}

extern "C" int shim_scaled_residual(int isa, const double *counts, const double *reference, const double *inverse_sigma,
                                    double scale, size_t count, float *out) {
    return KERNELS(residual, isa).scaled_residual(counts, reference, inverse_sigma, scale, count, out) ? 1 : 0;
}

extern "C" void shim_residual_project(int isa, const double *units, size_t planes, size_t count, double *vector) {
    KERNELS(residual, isa).project_out(units, planes, count, vector);
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
    if (!KERNELS(residual, isa).components(rows, frames, frame, rows.cols, vector, components))
        return 0;
    for (size_t r = 0; r < rows.rows; r++) {
        for (size_t f = 0; f < frames; f++)
            row[f] = out + f * pixels + r * rows.cols;
        KERNELS(residual, isa).project_row(rows, frames, components, r, vector, row);
    }
    return 1;
}

extern "C" double shim_residual_inner(int isa, const double *a, const double *b, size_t count) {
    return KERNELS(residual, isa).inner(a, b, count);
}

extern "C" double shim_magnitude(int isa, const double *residual, size_t count, double most) {
    return KERNELS(residual, isa).magnitude(residual, count, most);
}

extern "C" float shim_magnitude_float(int isa, const float *residual, size_t count, float most) {
    return KERNELS(residual, isa).magnitude_float(residual, count, most);
}

extern "C" double shim_residual_inner_float(int isa, const float *a, const float *b, size_t count) {
    return KERNELS(residual, isa).inner_float(a, b, count);
}
