// include/toliman/base.h: status names, last error, versions, properties of the machine.
//
// Slow OpenBLAS kernels: OpenBLAS selects its kernels by CPU model when it is loaded, and a library older than the CPU
// may fall back to an older core with narrower vectors. The library cannot change the selection afterwards. It compares
// the vector width of the selected core (by name) with the CPU's instruction set and reports the OPENBLAS_CORETYPE to
// set.
#include <cstring>
#include <initializer_list>
#include <thread>

#include "api/guard.hpp"
#include "api/struct_sizes.hpp"
#include "backend/blas.hpp"
#include "backend/fft.hpp"
#include "kernels/isa.hpp"

using namespace toliman;

namespace {

// Vector width in bits of the OpenBLAS kernels of this name.
int vector_bits(const char *core) noexcept {
    for (const char *name : {"SkylakeX", "Cooperlake", "SapphireRapids"})
        if (std::strcmp(core, name) == 0)
            return 512;
    for (const char *name : {"Haswell", "Zen", "Excavator", "Sandybridge", "Bulldozer", "Piledriver", "Steamroller"})
        if (std::strcmp(core, name) == 0)
            return 256;
    return 128;
}

// OPENBLAS_CORETYPE that fits this CPU; "" if the kernels in use have its vector width or the CPU is not x86-64.
const char *better_core(const char *core) noexcept {
#if defined(__x86_64__)
    const kernels::Isa isa = kernels::host_isa();
    if (isa == kernels::Isa::avx512 && vector_bits(core) < 512)
        return "SkylakeX";
    if (isa == kernels::Isa::avx2 && vector_bits(core) < 256)
        return "Haswell";
#else
    (void)core;
#endif
    return "";
}

} // namespace

extern "C" {

const char *toliman_last_error(void) noexcept {
    return last_error();
}

const char *toliman_last_error_field(void) noexcept {
    return last_error_field();
}

const char *toliman_version(void) noexcept {
    return TOLIMAN_VERSION;
}

int32_t toliman_abi_version(void) noexcept {
    return TOLIMAN_ABI_VERSION;
}

size_t toliman_get_struct_size(const char *name) noexcept {
    if (name != nullptr)
        for (const api::StructSize &entry : api::kStructSizes)
            if (std::strcmp(entry.name, name) == 0)
                return entry.size;
    return 0;
}

toliman_status toliman_get_machine(toliman_machine *out) noexcept {
    return api::guard([&] {
        const blas::Properties blas = blas::properties();
        toliman_machine machine = {};
        machine.processors = static_cast<int32_t>(std::thread::hardware_concurrency());
        machine.isa = kernels::host_isa_name();
        machine.blas_core = blas.core;
        machine.blas_config = blas.config;
        machine.blas_threads = blas.threads;
        machine.blas_better = better_core(blas.core);
        machine.blas_is_slow = machine.blas_better[0] != '\0';
        machine.fftw = fft::version();
        api::deliver(machine, out, "out");
    });
}

toliman_status toliman_get_blas_speed(double *gflops) noexcept {
    return api::guard([&] {
        api::required(gflops, "gflops");
        *gflops = blas::measure_gflops();
    });
}

} // extern "C"
