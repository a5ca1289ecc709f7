// One program that runs the whole network on each instruction set.
#include "chosen_isa.hpp"

// Chooses 0 baseline, 1 avx2 or 2 avx512; 0 where this processor lacks it.
extern "C" int shim_choose_isa(int isa) {
    toliman::kernels::chosen = static_cast<toliman::kernels::Isa>(isa);
    return toliman::kernels::runs(toliman::kernels::chosen) ? 1 : 0;
}
