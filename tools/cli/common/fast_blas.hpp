// Selects OpenBLAS kernels and threads, which OpenBLAS itself fixes when it is loaded.
#pragma once

namespace cli {

// Sets OPENBLAS_CORETYPE and OPENBLAS_NUM_THREADS unless they are set, and restarts the program. Call this first.
void restart_with_fast_blas(char **argv);

} // namespace cli
