// Lets one program run, or detect, each instruction set.
#include "chosen_isa.hpp"

// Selects 0 baseline, 1 avx2 or 2 avx512; returns 0 if this processor does not support it.
extern "C" int shim_choose_isa(int isa) {
    toliman::kernels::chosen = static_cast<toliman::kernels::Isa>(isa);
    return toliman::kernels::runs(toliman::kernels::chosen) ? 1 : 0;
}
