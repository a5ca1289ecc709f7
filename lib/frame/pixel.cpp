#include "frame/pixel.hpp"

namespace toliman {

size_t size_of(Pixel pixel) noexcept {
    return with_pixels(pixel, nullptr, [](auto first) { return sizeof *first; });
}

ImageView<const double> PixelFrames::frame(size_t i, Buffer<double> &scratch) const {
    const size_t at = i * frame_stride;
    if (pixel == Pixel::f64)
        return {static_cast<const double *>(pixels) + at, rows, cols, stride};
    scratch.resize(rows * cols);
    with_pixels(pixel, pixels, [&](auto first) {
        for (size_t r = 0; r < rows; r++)
            for (size_t c = 0; c < cols; c++)
                scratch[r * cols + c] =
                    static_cast<double>(ValueOf<std::decay_t<decltype(*first)>>(first[at + r * stride + c]));
    });
    return {scratch.data(), rows, cols, cols};
}

} // namespace toliman
