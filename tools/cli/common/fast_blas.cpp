#include "common/fast_blas.hpp"

#include <cstdlib>
#include <unistd.h>

#include <toliman/toliman.hpp>

namespace cli {

void restart_with_fast_blas(char **argv) {
    auto machine = toliman::sized<toliman_machine>();
    toliman::check(toliman_get_machine(&machine));
    bool changed = false;
    if (machine.blas_is_slow != 0 && std::getenv("OPENBLAS_CORETYPE") == nullptr)
        changed = ::setenv("OPENBLAS_CORETYPE", machine.blas_better, 1) == 0;
    if (machine.blas_threads != 1 && std::getenv("OPENBLAS_NUM_THREADS") == nullptr)
        changed = ::setenv("OPENBLAS_NUM_THREADS", "1", 1) == 0 || changed;
    if (changed)
        ::execv("/proc/self/exe", argv); // on failure continue with the slower kernels, which are correct too
}

} // namespace cli
