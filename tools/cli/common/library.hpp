// Short forms of calls of the library that come in pairs.
#pragma once
#include <vector>

#include <toliman/toliman.hpp>

namespace cli {

// The bytes that save(data, capacity, &size) delivers.
template <class Save> std::vector<unsigned char> bytes_of(Save save) {
    size_t size = 0;
    toliman::check_asked(save(nullptr, size_t{0}, &size));
    std::vector<unsigned char> bytes(size);
    toliman::check(save(bytes.data(), size, &size));
    return bytes;
}

// Contiguous frames as a toliman_image, of doubles unless its `pixel` is changed.
inline toliman_image plain_image(const void *frames) noexcept {
    toliman_image image = toliman::sized<toliman_image>();
    image.pixels = frames;
    return image;
}

} // namespace cli
