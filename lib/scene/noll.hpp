// Noll indices as keys of an object.
#pragma once
#include <charconv>
#include <string>

#include "kernels/zernike.hpp"
#include "scene/reader.hpp"

namespace toliman::scene {

// The index that a key of `object` names, from `first` to kernels::kLargestNoll: decimal digits without leading zeros.
inline int noll_of(const Reader &object, const std::string &key, int first) {
    int noll = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), noll);
    if (error != std::errc() || end != key.data() + key.size() || std::to_string(noll) != key || noll < first ||
        noll > kernels::kLargestNoll)
        object.refuse(Status::scene, key.c_str(), ": unknown key; must be a Noll index from %d to %d", first,
                      kernels::kLargestNoll);
    return noll;
}

} // namespace toliman::scene
