// Replaces the library's kernels/isa.cpp, so that one program can run every instruction set. To be included by a single
// source file of a program that is linked with the static library.
#ifndef TOLIMAN_TESTS_CHOSEN_ISA_HPP
#define TOLIMAN_TESTS_CHOSEN_ISA_HPP

#include "kernels/isa.hpp"

namespace toliman::kernels {

static Isa chosen = Isa::baseline;

Isa host_isa() noexcept {
    return chosen;
}

const char *host_isa_name() noexcept {
    return chosen == Isa::avx512 ? "avx512" : chosen == Isa::avx2 ? "avx2" : "baseline";
}

// Whether this processor supports it.
static inline bool runs(Isa isa) noexcept {
#if defined(__x86_64__)
    if (isa == Isa::avx512)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    if (isa == Isa::avx2)
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#endif
    return isa == Isa::baseline;
}

} // namespace toliman::kernels

#endif
