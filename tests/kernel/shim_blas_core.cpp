// Lets one program select the instruction set that the library detects.
#include "chosen_isa.hpp"

extern "C" void shim_choose_isa(int isa) {
    toliman::kernels::chosen = static_cast<toliman::kernels::Isa>(isa);
}
