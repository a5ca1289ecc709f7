// The weights blob "TLMW", tools/docs/formats.md: a whole network as bytes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cae/network.hpp"
#include "cae/payload.hpp"
#include "cae/training.hpp"

namespace toliman::cae {

constexpr size_t kMaxBlob = 8u << 20; // above what any blob can need

struct Encodings {
    Encoding weights = Encoding::float32, planes = Encoding::float32;
};

// The same network and training (NULL: none) give the same bytes; so does what is loaded from them. Status::range for
// numbers that no blob holds.
std::vector<uint8_t> to_blob(const Network &network, const Encodings &encodings, const Training *training);

struct Blob {
    Network network;
    std::optional<Training> training;
};

// Status::format for anything but a whole, undamaged blob of this version with usable numbers.
Blob from_blob(const void *bytes, size_t size);

} // namespace toliman::cae
