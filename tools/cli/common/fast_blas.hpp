// OpenBLAS chooses kernels and threads once, when it is loaded.
#pragma once

namespace cli {

// Sets the best ones in the environment, unless they are set, and starts the program again. To be called first.
void restart_with_fast_blas(char **argv);

} // namespace cli
