// Mean structural similarity (SSIM) of two images, in double precision.
#pragma once
#include <cstddef>

namespace toliman::kernels {

// Given     a, b [rows][cols], with a dynamic range of 1; rows and cols >= 11; scratch [5][cols]
// Returned  mean structural similarity over the pixels whose window lies entirely in the image
// Notes     11x11 Gaussian window of sigma 1.5 px and unit sum, K1 = 0.01, K2 = 0.03, biased moments
// Reference Wang, Bovik, Sheikh, Simoncelli (2004), IEEE Trans. Image Processing 13, 600
double mean_ssim(const double *a, const double *b, size_t rows, size_t cols, double *scratch) noexcept;

} // namespace toliman::kernels
