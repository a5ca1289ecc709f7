#include "isa_tables.hpp"
#include "kernels/project.hpp"

using namespace toliman::kernels;

extern "C" {

// The sum of (a_i - reference_i) b_i, in two parts; NaN if not all a are finite.
double shim_dot_difference(int isa, const double *a, const double *reference, const double *b, size_t n, size_t first) {
    Dot dot;
    const bool finite = KERNELS(project, isa).add_difference(a, reference, b, first, dot) &&
                        KERNELS(project, isa).add_difference(a + first, reference + first, b + first, n - first, dot);
    return finite ? dot.total() : __builtin_nan("");
}

double shim_dot(const double *a, const double *b, size_t n) {
    return toliman::kernels::dot(a, b, n);
}

void shim_whiten(int isa, const double *image, const double *variance, size_t n, double *out) {
    KERNELS(project, isa).whiten(image, variance, n, out);
}

void shim_project_out(const double *units, size_t count, size_t n, double *vector) {
    toliman::kernels::project_out(units, count, n, vector);
}

size_t shim_orthonormalise(double *vectors, size_t count, size_t n) {
    return toliman::kernels::orthonormalise(vectors, count, n);
}
}
