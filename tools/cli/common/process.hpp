// What the program asks of OpenBLAS and of the C library before it begins.
#pragma once
#include <cstdlib>
#include <limits>
#include <malloc.h>
#include <unistd.h>

#include "common/common.hpp"

namespace cli {

// Keeps the memory of images that are freed for the next ones, unless the user chose how memory is allocated: to touch
// new pages of the system took a third of the processor time of a calibration. Images above the largest are not kept.
inline void keep_freed_memory() {
    if (std::getenv("GLIBC_TUNABLES") != nullptr || std::getenv("MALLOC_ARENA_MAX") != nullptr)
        return;
    constexpr int kLargestKept = 32 << 20; // bytes, the most that every glibc allows
    ::mallopt(M_MMAP_THRESHOLD, kLargestKept);
    ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
    ::mallopt(M_ARENA_MAX, 1); // memory that a thread frees serves the others
}

// Sets OPENBLAS_CORETYPE and OPENBLAS_NUM_THREADS unless they are set, and restarts the program: OpenBLAS takes them
// when it is loaded.
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

// Call this first.
inline void prepare_process(char **argv) {
    restart_with_fast_blas(argv);
    keep_freed_memory();
}

} // namespace cli
