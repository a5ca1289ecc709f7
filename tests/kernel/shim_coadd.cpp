// C interface of the kernels of sums of frames.
#include "isa_tables.hpp"
#include "kernels/coadd.hpp"

using namespace toliman::kernels;

namespace {

struct Given {
    CoaddFrame frame;
    CoaddModel model;
    CoaddPixels pixels;
};

Given given(const uint16_t *counts, const size_t *shape, const uint16_t *images, size_t stride, const float *scales,
            const float *arrays, const float *limits) {
    const size_t size = shape[0] * stride, pixels = shape[0] * shape[1];
    const bool uniform = limits[3] != 0;
    const auto *const slopes = reinterpret_cast<const int16_t *>(images);
    return {{counts, shape[2], shape[0], shape[1]},
            {images, slopes + size, slopes + 2 * size, stride, scales[0], scales[1]},
            {uniform, arrays, arrays + pixels, arrays + 2 * pixels, arrays + 3 * pixels, limits[0], limits[1],
             static_cast<uint16_t>(limits[2]), limits[4] != 0}};
}

} // namespace

// shape: rows, cols and stride of the counts; images: light and slopes [rows][stride]; scales: of light and slopes;
// arrays: gain, offset, spread, added [rows][cols]; limits: least, limit, most, uniform, far.
extern "C" void shim_coadd_accumulate(int isa, const uint16_t *counts, const size_t *shape, const uint16_t *images,
                                      size_t stride, const float *scales, const float *arrays, const float *limits,
                                      float flux, size_t start, size_t step, double *sums) {
    const Given g = given(counts, shape, images, stride, scales, arrays, limits);
    KERNELS(coadd, isa).accumulate(g.frame, g.model, g.pixels, flux, start, step, sums);
}

extern "C" size_t shim_coadd_test(int isa, const uint16_t *counts, const size_t *shape, const uint16_t *images,
                                  size_t stride, const float *scales, const float *arrays, const float *limits,
                                  const float *fitted, uint32_t *found, size_t capacity) {
    const Given g = given(counts, shape, images, stride, scales, arrays, limits);
    return KERNELS(coadd, isa).test(g.frame, g.model, g.pixels, {fitted[0], fitted[1], fitted[2]}, 36, found, capacity);
}

extern "C" void shim_coadd_add(int isa, const uint16_t *counts, const size_t *shape, uint32_t *sums) {
    KERNELS(coadd, isa).add({counts, shape[2], shape[0], shape[1]}, sums);
}

extern "C" size_t shim_coadd_zero_rows(int isa, const uint16_t *counts, const size_t *shape) {
    return KERNELS(coadd, isa).zero_rows({counts, shape[2], shape[0], shape[1]});
}
