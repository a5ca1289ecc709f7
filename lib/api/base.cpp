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

struct Code {
    Status status;
    toliman_status code;
    const char *name;
};
#define TOLIMAN_CODE(internal, code)                                                                                   \
    { Status::internal, code, #code }
constexpr Code kCodes[] = {
    TOLIMAN_CODE(ok, TOLIMAN_OK),
    TOLIMAN_CODE(internal, TOLIMAN_E_INTERNAL),
    TOLIMAN_CODE(argument, TOLIMAN_E_ARGUMENT),
    TOLIMAN_CODE(memory, TOLIMAN_E_MEMORY),
    TOLIMAN_CODE(not_found, TOLIMAN_E_NOT_FOUND),
    TOLIMAN_CODE(format, TOLIMAN_E_FORMAT),
    TOLIMAN_CODE(scene, TOLIMAN_E_SCENE),
    TOLIMAN_CODE(unsupported, TOLIMAN_E_UNSUPPORTED),
    TOLIMAN_CODE(write, TOLIMAN_E_WRITE),
    TOLIMAN_CODE(cancelled, TOLIMAN_E_CANCELLED),
    TOLIMAN_CODE(range, TOLIMAN_E_RANGE),
    TOLIMAN_CODE(mismatch, TOLIMAN_E_MISMATCH),
    TOLIMAN_CODE(capacity, TOLIMAN_E_CAPACITY),
    TOLIMAN_CODE(state, TOLIMAN_E_STATE),
    TOLIMAN_CODE(lost, TOLIMAN_E_LOST),
};
#undef TOLIMAN_CODE

constexpr bool codes_agree() {
    for (const Code &entry : kCodes)
        if (static_cast<toliman_status>(entry.status) != entry.code)
            return false;
    return true;
}
static_assert(codes_agree(), "base/error.hpp and toliman/base.h number the codes differently");

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

const char *toliman_status_name(toliman_status status) noexcept {
    for (const Code &entry : kCodes)
        if (entry.code == status)
            return entry.name;
    return "TOLIMAN_E_?";
}

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
