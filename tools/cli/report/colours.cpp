#include "report/colours.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <png.h>

#include "common/failure.hpp"
#include "report/words.hpp"

namespace cli {

namespace {

using Colour = std::array<uint8_t, 3>; // red, green, blue

// Colours at even steps, straight lines between.
constexpr uint32_t kViridis[] = {0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e, 0x2a788e, 0x23888e,
                                 0x1f988b, 0x22a884, 0x35b779, 0x54c568, 0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725};
constexpr uint32_t kBlueRed[] = {0x053061, 0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7,
                                 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b, 0x67001f};
constexpr unsigned kShifts[] = {16, 8, 0}; // of red, green, blue
constexpr Colour kNothing = {0xb8, 0xb8, 0xb8};
constexpr const char *kLines[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00",
                                  "#7b2d00", "#56b4e9", "#8800ee", "#aabb66"};
constexpr int kMarkers[] = {5, 7, 9, 11, 13}; // of gnuplot: filled square, circle, triangles, diamond

struct Anchors {
    const uint32_t *colours;
    size_t count;
};

Anchors anchors_of(Palette palette) {
    return palette == Palette::intensity ? Anchors{kViridis, std::size(kViridis)}
                                         : Anchors{kBlueRed, std::size(kBlueRed)};
}

// Part 0 ... 1 of the palette.
Colour colour_at(double part, Palette palette) {
    const Anchors anchors = anchors_of(palette);
    const double place = std::clamp(part, 0.0, 1.0) * static_cast<double>(anchors.count - 1);
    const size_t first = std::min(static_cast<size_t>(place), anchors.count - 2);
    const double share = place - static_cast<double>(first);
    Colour colour;
    for (size_t i = 0; i < colour.size(); i++) {
        const auto channel = [&](size_t k) { return static_cast<double>(anchors.colours[k] >> kShifts[i] & 255); };
        colour[i] = static_cast<uint8_t>(std::lround(channel(first) + share * (channel(first + 1) - channel(first))));
    }
    return colour;
}

double part_of(double value, const Scale &scale) {
    if (!scale.log || std::isnan(value))
        return (value - scale.low) / (scale.high - scale.low);
    return value > 0 ? std::log(value / scale.low) / std::log(scale.high / scale.low) : 0;
}

Colour colour_of(double value, const Scale &scale) {
    const double part = part_of(value, scale);
    return std::isnan(part) ? kNothing : colour_at(part, scale.palette);
}

} // namespace

std::string png_of(const std::vector<double> &values, size_t rows, size_t cols, const Scale &scale) {
    std::vector<uint8_t> pixels;
    pixels.reserve(3 * rows * cols);
    for (size_t row = rows; row-- > 0;)
        for (size_t col = 0; col < cols; col++) {
            const Colour colour = colour_of(values[row * cols + col], scale);
            pixels.insert(pixels.end(), colour.begin(), colour.end());
        }
    png_image image = {};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(cols);
    image.height = static_cast<png_uint_32>(rows);
    image.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    std::string bytes(size, '\0');
    if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
        throw Failure(kExitInternal, std::string("libpng: ") + image.message);
    bytes.resize(size);
    return bytes;
}

std::string colour_box(const Scale &scale) {
    const Anchors anchors = anchors_of(scale.palette);
    std::string text = "set palette defined (";
    for (size_t i = 0; i < anchors.count; i++)
        text += printed("%s%zu '#%06x'", i > 0 ? ", " : "", i, anchors.colours[i]);
    return text + printed(") maxcolors 256\nset cbrange [%.17g:%.17g]\n%s logscale cb\n", scale.low, scale.high,
                          scale.log ? "set" : "unset");
}

const char *line_colour(size_t i) {
    return kLines[i % std::size(kLines)];
}

std::string mark(size_t i) {
    static_assert(std::size(kLines) % std::size(kMarkers) != 0); // or the pairs begin anew with the colours
    return printed("pt %d lc rgb '%s'", kMarkers[i % std::size(kMarkers)], line_colour(i));
}

} // namespace cli
