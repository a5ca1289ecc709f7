// The bank "TLMB" (tools/docs/formats.md) as bytes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bank/bank.hpp"
#include "cae/payload.hpp"

namespace toliman::bank {

// Bytes of the weights of one network, uncompressed.
size_t weight_bytes(const cae::Layout &layout, cae::Encoding encoding) noexcept;
// Above the largest file.
size_t most_bytes() noexcept;

// Deterministic, and idempotent after a load with the same encoding. Status::range for weights out of range.
std::vector<uint8_t> to_bytes(const Bank &bank, cae::Encoding encoding);

// Status::format unless the bytes are complete, undamaged, of a known version, and all numbers in range.
Bank from_bytes(const void *bytes, size_t size);

// What the training of a network has set, for a journal; and sets it in network i of a bank with these options.
std::vector<uint8_t> training_of(const Network &network);
void set_training(const std::vector<uint8_t> &bytes, size_t i, const Options &options, Network &network);

} // namespace toliman::bank
