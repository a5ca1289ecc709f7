
#include "api/pixel_frames.hpp"
#include "api/common.hpp"

namespace toliman::api {

namespace {

// 0 means the side that the object requires.
void check_side(int64_t given, size_t wanted, const char *name) {
    if (given != 0 && given != static_cast<int64_t>(wanted))
        fail(Status::argument, "{image->%s} = %lld: must be %zu, or 0 for the default", name,
             static_cast<long long>(given), wanted);
}

size_t stride_of(int64_t given, int64_t least, size_t otherwise, const char *name) {
    if (given != 0 && given < least)
        fail(Status::argument, "{image->%s} = %lld: must be at least %lld pixels, or 0 for frames without gaps", name,
             static_cast<long long>(given), static_cast<long long>(least));
    return given != 0 ? static_cast<size_t>(given) : otherwise;
}

// The extent from the first pixel to the end of the last one must not exceed PTRDIFF_MAX bytes, the largest object.
void check_extent(const PixelFrames &frames, size_t count) {
    size_t row = 0, frame = 0, pixels = 0, bytes = 0;
    const bool large = __builtin_mul_overflow(frames.rows - 1, frames.stride, &row) ||
                       __builtin_mul_overflow(count - 1, frames.frame_stride, &frame) ||
                       __builtin_add_overflow(row, frame, &pixels) ||
                       __builtin_add_overflow(pixels, frames.cols, &pixels) ||
                       __builtin_mul_overflow(pixels, size_of(frames.pixel), &bytes) || bytes > PTRDIFF_MAX;
    if (large)
        fail(Status::range, "{image}: %zu frames of %zux%zu pixels, %zu pixels apart: does not fit in memory", count,
             frames.rows, frames.cols, frames.frame_stride);
}

} // namespace

PixelFrames frames_of(const toliman_image *image, size_t count, size_t rows, size_t cols) {
    required(image, "image");
    const toliman_image given = copied(image, "image");
    required(given.pixels, "image->pixels");
    check_side(given.rows, rows, "rows");
    check_side(given.cols, cols, "cols");
    PixelFrames frames = {kPixels.to_enum_or(given.pixel, Pixel::f64, "image->pixel"), given.pixels, rows, cols, 0, 0};
    frames.stride = stride_of(given.stride, static_cast<int64_t>(cols), cols, "stride");
    size_t packed = 0; // if this product overflows, check_extent fails
    if (__builtin_mul_overflow(rows, frames.stride, &packed))
        packed = PTRDIFF_MAX;
    frames.frame_stride = stride_of(given.frame_stride, 1, packed, "frame_stride");
    check_extent(frames, count);
    frames.windows = given.windows;
    for (size_t i = 0; frames.windows != nullptr && i < 2 * count; i++)
        if (frames.windows[i] < -kFarthestWindow || frames.windows[i] > kFarthestWindow)
            fail(Status::argument, "{image->windows}[%zu][%zu] = %lld: must be in [-2^31, 2^31]", i / 2, i % 2,
                 static_cast<long long>(frames.windows[i]));
    if (reinterpret_cast<uintptr_t>(given.pixels) % size_of(frames.pixel) != 0)
        fail(Status::argument, "{image->pixels}: must be aligned to %zu bytes, the size of a pixel",
             size_of(frames.pixel));
    return frames;
}

} // namespace toliman::api
