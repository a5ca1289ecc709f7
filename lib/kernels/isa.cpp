#include "kernels/isa.hpp"

namespace toliman::kernels {

Isa host_isa() noexcept {
#if defined(__x86_64__)
    // The extensions of x86-64-v4 and x86-64-v3, for which the kernels are compiled (tools/cmake/library.cmake).
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return Isa::avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
        return Isa::avx2;
#endif
    return Isa::baseline;
}

const char *host_isa_name() noexcept {
    constexpr const char *kNames[] = {"baseline", "avx2", "avx512"}; // as in Isa
    return kNames[static_cast<int>(host_isa())];
}

} // namespace toliman::kernels
