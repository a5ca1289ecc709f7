// Stands in for kernels/isa.cpp, so that one program can run the whole network on each instruction set.
#include "kernels/isa.hpp"

namespace {

toliman::kernels::Isa chosen = toliman::kernels::Isa::baseline;

} // namespace

namespace toliman::kernels {

Isa host_isa() noexcept {
    return chosen;
}

const char *host_isa_name() noexcept {
    return chosen == Isa::avx512 ? "avx512" : chosen == Isa::avx2 ? "avx2" : "baseline";
}

} // namespace toliman::kernels

// Chooses 0 baseline, 1 avx2 or 2 avx512; 0 where this processor lacks it.
extern "C" int shim_choose_isa(int isa) {
#if defined(__x86_64__)
    const bool runs[] = {true, __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"),
                         __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")};
#else
    const bool runs[] = {true, false, false};
#endif
    chosen = static_cast<toliman::kernels::Isa>(isa);
    return runs[isa] ? 1 : 0;
}
