// C interface of the decorrelation.
#include "kernels/decorrelate.hpp"

extern "C" int shim_decorrelate_isas(void) {
    return static_cast<int>(toliman::kernels::host_isa()) + 1;
}

extern "C" void shim_decorrelate(int isa, float *samples, size_t n, size_t count, float *work) {
#if defined(__x86_64__)
    using namespace toliman::kernels;
    const DecorrelateKernels *tables[] = {&decorrelate_baseline, &decorrelate_avx2, &decorrelate_avx512};
    tables[isa]->decorrelate(samples, n, count, work);
#else
    (void)isa;
    toliman::kernels::decorrelate_baseline.decorrelate(samples, n, count, work);
#endif
}
