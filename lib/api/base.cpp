// include/toliman/base.h: status names, last error, versions, properties of the machine.
#include <cstring>
#include <thread>

#include "api/guard.hpp"
#include "api/struct_sizes.hpp"
#include "backend/blas.hpp"
#include "backend/fft.hpp"
#include "kernels/isa.hpp"

using namespace toliman;

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
        constexpr int kVectorBits[] = {0, 256, 512}; // as in Isa
        toliman_machine machine = {};
        machine.processors = static_cast<int32_t>(std::thread::hardware_concurrency());
        machine.isa = kernels::host_isa_name();
        machine.blas_core = blas.core;
        machine.blas_config = blas.config;
        machine.blas_threads = blas.threads;
        machine.blas_better = blas::better_core(blas.core, kVectorBits[static_cast<int>(kernels::host_isa())]);
        machine.blas_is_slow = machine.blas_better[0] != '\0';
        machine.fftw = fft::version();
        api::deliver(machine, out, "out");
    });
}

} // extern "C"
