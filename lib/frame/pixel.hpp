// Pixel types of the caller's frames, and their conversion to double.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>

#include "base/buffer.hpp"
#include "base/view.hpp"
#include "frame/detector_window.hpp"

namespace toliman {

// In the order of TOLIMAN_PIXEL_...; those ending in `be` are big-endian, the others little-endian.
enum class Pixel : int32_t { u8, u16, u32, i16, i32, f32, f64, u16be, u32be, i16be, f32be };

size_t size_of(Pixel pixel) noexcept;

inline uint16_t swap_bytes(uint16_t bits) noexcept {
    return __builtin_bswap16(bits);
}
inline uint32_t swap_bytes(uint32_t bits) noexcept {
    return __builtin_bswap32(bits);
}

// A big-endian number in memory, which converts to a T.
template <class T> class BigEndian {
  public:
    operator T() const noexcept {
        const Bits swapped = swap_bytes(bits_);
        T value;
        std::memcpy(&value, &swapped, sizeof value);
        return value;
    }

  private:
    using Bits = std::conditional_t<sizeof(T) == 2, uint16_t, uint32_t>;
    Bits bits_;
};

// The native type that a pixel in memory converts to.
template <class T> struct Reads { using Value = T; };
template <class T> struct Reads<BigEndian<T>> { using Value = T; };
template <class T> using ValueOf = typename Reads<T>::Value;

// Returns work(first), where first points to pixels of the kind's type.
template <class Work> auto with_pixels(Pixel kind, const void *pixels, Work work) {
    switch (kind) {
    case Pixel::u8:
        return work(static_cast<const uint8_t *>(pixels));
    case Pixel::u16:
        return work(static_cast<const uint16_t *>(pixels));
    case Pixel::u32:
        return work(static_cast<const uint32_t *>(pixels));
    case Pixel::i16:
        return work(static_cast<const int16_t *>(pixels));
    case Pixel::i32:
        return work(static_cast<const int32_t *>(pixels));
    case Pixel::f32:
        return work(static_cast<const float *>(pixels));
    case Pixel::f64:
        break;
    case Pixel::u16be:
        return work(static_cast<const BigEndian<uint16_t> *>(pixels));
    case Pixel::u32be:
        return work(static_cast<const BigEndian<uint32_t> *>(pixels));
    case Pixel::i16be:
        return work(static_cast<const BigEndian<int16_t> *>(pixels));
    case Pixel::f32be:
        return work(static_cast<const BigEndian<float> *>(pixels));
    }
    return work(static_cast<const double *>(pixels));
}

// Frames of one pixel type, at equal distances in memory.
struct PixelFrames {
    Pixel pixel;
    const void *pixels;
    size_t rows, cols;
    size_t stride, frame_stride;      // in pixels, from row to row and from frame to frame
    const int64_t *windows = nullptr; // [frames][2], or NULL: not known

    // Returns frame i as doubles: in place if its pixels are doubles, else converted into scratch.
    ImageView<const double> frame(size_t i, Buffer<double> &scratch) const;
    std::optional<DetectorWindow> window(size_t i) const noexcept {
        return windows != nullptr ? std::optional(DetectorWindow{windows[2 * i], windows[2 * i + 1]}) : std::nullopt;
    }
};

} // namespace toliman
