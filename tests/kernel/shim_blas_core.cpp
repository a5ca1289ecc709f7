// One program that is told to be on each instruction set.
#include "chosen_isa.hpp"

extern "C" void shim_choose_isa(int isa) {
    toliman::kernels::chosen = static_cast<toliman::kernels::Isa>(isa);
}
