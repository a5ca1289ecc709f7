// Converts the caller's toliman_image to PixelFrames.
#pragma once
#include <toliman/image.h>

#include "api/choice.hpp"
#include "frame/pixel.hpp"

namespace toliman::api {

constexpr Choice<Pixel> kPixels = {TOLIMAN_PIXEL_U8, TOLIMAN_PIXEL_F32BE, "TOLIMAN_PIXEL_..."};
constexpr int64_t kFarthestWindow = int64_t{1} << 31; // first row or column, of either sign

// Returns `count` > 0 frames of rows x cols. Status::argument for another shape, an invalid stride or misaligned
// pixels; Status::range for frames that do not fit in memory.
PixelFrames frames_of(const toliman_image *image, size_t count, size_t rows, size_t cols);

} // namespace toliman::api
