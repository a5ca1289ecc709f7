#include "kernels/zernike.hpp"

extern "C" {

double shim_zernike(int noll, double x, double y) {
    return toliman::kernels::zernike(noll, x, y);
}

int shim_largest_noll(void) {
    return toliman::kernels::kLargestNoll;
}
}
