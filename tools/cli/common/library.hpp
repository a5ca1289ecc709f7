// Short forms of calls of the library.
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

inline toliman_measure_info info_of(const toliman_measure *measure) {
    return toliman::result<toliman_measure_info>(toliman_measure_get_info, measure);
}

// Numbers of the samples, by their name in measure.h; empty if the series does not have them.
inline std::vector<double> values_of(const toliman_measure *measure, const char *name) {
    std::vector<double> values(static_cast<size_t>(info_of(measure).n));
    const toliman_status status = toliman_measure_get_values(measure, name, values.data(), values.size());
    if (status == TOLIMAN_E_NOT_FOUND)
        return {};
    toliman::check(status);
    return values;
}

} // namespace cli
