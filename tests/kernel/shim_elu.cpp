// C interface of the ELU kernel.
#include "isa_tables.hpp"
#include "kernels/elu.hpp"

extern "C" void shim_elu(int isa, float *values, size_t count) {
    KERNELS(elu, isa).elu(values, count);
}
