#include "kernels/project.hpp"

extern "C" {

double shim_dot(const double *a, const double *b, size_t n) {
    return toliman::kernels::dot(a, b, n);
}

void shim_whiten(const double *image, const double *variance, size_t n, double *out) {
    toliman::kernels::whiten(image, variance, n, out);
}

void shim_project_out(const double *units, size_t count, size_t n, double *vector) {
    toliman::kernels::project_out(units, count, n, vector);
}

size_t shim_orthonormalise(double *vectors, size_t count, size_t n) {
    return toliman::kernels::orthonormalise(vectors, count, n);
}
}
