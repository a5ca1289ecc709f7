// Selects OpenBLAS kernels and threads, which OpenBLAS itself fixes when it is loaded.
#pragma once
#include <cstdlib>
#include <unistd.h>

#include "common/common.hpp"

namespace cli {

// Sets OPENBLAS_CORETYPE and OPENBLAS_NUM_THREADS unless they are set, and restarts the program. Call this first.
inline void restart_with_fast_blas(char **argv) {
    auto machine = toliman::sized<toliman_machine>();
    toliman::check(toliman_get_machine(&machine));
    const auto set = [](bool needed, const char *name, const char *value) {
        return needed && std::getenv(name) == nullptr && ::setenv(name, value, 1) == 0;
    };
    const bool kernels = set(machine.blas_is_slow != 0, "OPENBLAS_CORETYPE", machine.blas_better);
    if (set(machine.blas_threads != 1, "OPENBLAS_NUM_THREADS", "1") || kernels)
        ::execv("/proc/self/exe", argv); // on failure continue with the slower kernels, which are correct too
}

} // namespace cli
