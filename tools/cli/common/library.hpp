// Short forms of calls of the library.
#pragma once
#include <vector>

#include <toliman/toliman.hpp>

#include "common/terminal.hpp"

namespace cli {

// The bytes that save(data, capacity, &size) delivers.
template <class Save> std::vector<unsigned char> bytes_of(Save save) {
    size_t size = 0;
    toliman::check_asked(save(nullptr, size_t{0}, &size));
    std::vector<unsigned char> bytes(size);
    toliman::check(save(bytes.data(), size, &size));
    return bytes;
}

// Items 0 ... count - 1 that get(object, i, &item) delivers.
template <class Object, class Item>
std::vector<Item> items_of(toliman_status (*get)(const Object *, int64_t, Item *), const Object *object,
                           int64_t count) {
    std::vector<Item> items(static_cast<size_t>(count), toliman::sized<Item>());
    for (int64_t i = 0; i < count; i++)
        toliman::check(get(object, i, &items[static_cast<size_t>(i)]));
    return items;
}

// All items that get(items, capacity, &count) delivers.
template <class Item, class Get> std::vector<Item> all_of(Get get) {
    size_t count = 0;
    toliman::check_asked(get(nullptr, size_t{0}, &count));
    std::vector<Item> items(count, toliman::sized<Item>());
    if (count > 0)
        toliman::check(get(items.data(), count, &count));
    return items;
}

// Options of a long call, which shows its progress and is stopped by a signal.
template <class Options> Options with_progress(Progress &progress) {
    auto options = toliman::sized<Options>();
    options.progress = Progress::callback;
    options.progress_data = &progress;
    return options;
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

// The name of a series in messages.
inline std::string name_of(const toliman_measure *series) {
    return info_of(series).name;
}

// A copy of a series in which the members of data replace its own.
inline toliman::measurements changed(const toliman_measure *series, toliman_measure_data data) {
    data.original = series;
    return toliman::make<toliman::measurements>(toliman_measure_create, &data);
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
