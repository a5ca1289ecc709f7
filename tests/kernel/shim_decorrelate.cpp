// C interface of the decorrelation.
#include "isa_tables.hpp"
#include "kernels/decorrelate.hpp"

extern "C" void shim_decorrelate(int isa, float *samples, size_t n, size_t count, float *work) {
    KERNELS(decorrelate, isa).decorrelate(samples, n, count, work);
}
