// The tables of kernels of each instruction set, and the number of sets that this processor runs.
#ifndef TOLIMAN_TESTS_KERNEL_ISA_TABLES_HPP
#define TOLIMAN_TESTS_KERNEL_ISA_TABLES_HPP

#include "kernels/isa.hpp"

// The table of kernels `name` for baseline, avx2, avx512 = 0, 1, 2.
#if defined(__x86_64__)
#define KERNELS(name, isa)                                                                                             \
    (*(isa == 0   ? &toliman::kernels::name##_baseline                                                                 \
       : isa == 1 ? &toliman::kernels::name##_avx2                                                                     \
                  : &toliman::kernels::name##_avx512))
#else
#define KERNELS(name, isa) (static_cast<void>(isa), toliman::kernels::name##_baseline)
#endif

extern "C" int shim_isas(void) {
    return static_cast<int>(toliman::kernels::host_isa()) + 1;
}

#endif
