// C interface of the decorrelation.
#include "kernels/decorrelate.hpp"

extern "C" void shim_decorrelate(float *samples, size_t n, size_t count, float *work) {
    toliman::kernels::decorrelate(samples, n, count, work);
}
