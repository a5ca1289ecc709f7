// The weights blob "TLMW" (tools/docs/formats.md): a network, and optionally its training, as bytes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cae/network.hpp"
#include "cae/payload.hpp"
#include "cae/training.hpp"

namespace toliman::cae {

constexpr size_t kMaxBlob = 12u << 20; // bytes; above the largest blob

struct Encodings {
    Encoding weights = Encoding::float32, planes = Encoding::float32;
};

// Serialises a network and its training (NULL: none). Deterministic, and idempotent after a load with the same
// encodings. Status::range for numbers out of the format's range.
std::vector<uint8_t> to_blob(const Network &network, const Encodings &encodings, const Training *training);

struct Blob {
    Network network;
    std::optional<Training> training;
};

// Parses a blob. Status::format unless it is complete, undamaged, of a known version, and all its numbers are in range.
Blob from_blob(const void *bytes, size_t size);

} // namespace toliman::cae
