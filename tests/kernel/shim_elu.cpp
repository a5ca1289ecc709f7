// C interface of the ELU kernel.
#include "kernels/elu.hpp"

extern "C" int shim_elu_isas(void) {
    return static_cast<int>(toliman::kernels::host_isa()) + 1;
}

extern "C" void shim_elu(int isa, float *values, size_t count) {
#if defined(__x86_64__)
    const toliman::kernels::EluKernels *tables[] = {&toliman::kernels::elu_baseline, &toliman::kernels::elu_avx2,
                                                    &toliman::kernels::elu_avx512};
    tables[isa]->elu(values, count);
#else
    (void)isa;
    toliman::kernels::elu_baseline.elu(values, count);
#endif
}
