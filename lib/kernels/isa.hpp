// Choice of the instruction set at run time. Files named *.isa.cpp are compiled once per set, with TOLIMAN_ISA defined
// to its name. They keep all their code in namespace toliman::kernels::TOLIMAN_ISA, use no inline function of a shared
// header (the linker keeps one copy, perhaps that of a set that the CPU lacks) and publish one table of functions each:
//
//     namespace toliman::kernels { extern const PoissonKernels TOLIMAN_ISA_TABLE(poisson) = {...}; }
#pragma once

#define TOLIMAN_ISA_JOIN(name, isa) name##_##isa
#define TOLIMAN_ISA_JOIN2(name, isa) TOLIMAN_ISA_JOIN(name, isa)
#define TOLIMAN_ISA_TABLE(name) TOLIMAN_ISA_JOIN2(name, TOLIMAN_ISA)

namespace toliman::kernels {

enum class Isa { baseline, avx2, avx512 };

// The most capable set that both this CPU and the library support, and its name.
Isa host_isa() noexcept;
const char *host_isa_name() noexcept;

// Declares the tables of one kernel and the function name_kernels(), which returns the table for this CPU.
#if defined(__x86_64__)
#define TOLIMAN_ISA_DECLARE(Table, name)                                                                               \
    extern const Table name##_baseline, name##_avx2, name##_avx512;                                                    \
    inline const Table &name##_kernels() noexcept {                                                                    \
        static const Table *const tables[] = {&name##_baseline, &name##_avx2, &name##_avx512}; /* as in Isa */         \
        return *tables[static_cast<int>(host_isa())];                                                                  \
    }
#else
#define TOLIMAN_ISA_DECLARE(Table, name)                                                                               \
    extern const Table name##_baseline;                                                                                \
    inline const Table &name##_kernels() noexcept {                                                                    \
        return name##_baseline;                                                                                        \
    }
#endif

} // namespace toliman::kernels
