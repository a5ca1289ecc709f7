// Network layouts as constexpr tables: stages, tensors, offsets and layout hash.
//
// The encoder has four stages, 256x256x1 -> 128x128x8 -> 64x64x16 -> 32x32x32 -> 16x16x64, and a dense layer to one
// latent. The decoder mirrors it. Both layouts have the same tensors, in the order in which the weights blob stores
// them (tools/docs/formats.md). They differ in how a stage changes resolution:
//
//     flight  down: 3x3 convolution, 2x2 mean, ELU                 up: nearest up-sampling x2, 3x3 deconvolution, ELU
//     paper   down: 3x3 convolution, 2x2 maximum (switches), ELU   up: un-pooling with the switches, deconvolution, ELU
//
// The decoder's last stage is linear (no ELU). "Deconvolution" is the transposed convolution.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/hash.hpp"
#include "kernels/conv.hpp"

namespace toliman::cae {

constexpr size_t kSide = 256; // rows and columns of the network's input
constexpr size_t kPixels = kSide * kSide;
constexpr size_t kStages = 4;
constexpr size_t kDeepSide = 16; // rows and columns of the last stage's coarse image
constexpr size_t kDeepChannels = 64;
constexpr size_t kFeatures = kDeepSide * kDeepSide * kDeepChannels;

// Name and shape of a tensor of up to four dimensions; unused dimensions are 0.
struct Tensor {
    const char *name;
    uint32_t size[4];
    constexpr size_t count() const noexcept {
        size_t product = 1;
        for (const uint32_t n : size)
            product *= n != 0 ? n : 1;
        return product;
    }
};

// Convolution kernels are [coarse][fine][3][3] in encoder and decoder; dense weights are [row][col][channel].
constexpr size_t kTensors = 20;
using TensorTable = std::array<Tensor, kTensors>;
inline constexpr TensorTable kTensorTable = {{{"conv1.weight", {8, 1, 3, 3}},     {"conv1.bias", {8}},
                                              {"conv2.weight", {16, 8, 3, 3}},    {"conv2.bias", {16}},
                                              {"conv3.weight", {32, 16, 3, 3}},   {"conv3.bias", {32}},
                                              {"conv4.weight", {64, 32, 3, 3}},   {"conv4.bias", {64}},
                                              {"latent.weight", {16, 16, 64}},    {"latent.bias", {1}},
                                              {"expand.weight", {16, 16, 64}},    {"expand.bias", {16, 16, 64}},
                                              {"deconv4.weight", {64, 32, 3, 3}}, {"deconv4.bias", {32}},
                                              {"deconv3.weight", {32, 16, 3, 3}}, {"deconv3.bias", {16}},
                                              {"deconv2.weight", {16, 8, 3, 3}},  {"deconv2.bias", {8}},
                                              {"deconv1.weight", {8, 1, 3, 3}},   {"deconv1.bias", {1}}}};

// Shapes of the stages of both layouts, from the input to the features.
inline constexpr std::array<kernels::ConvShape, kStages> kShapes = {
    {{128, 128, 1, 8}, {64, 64, 8, 16}, {32, 32, 16, 32}, {16, 16, 32, 64}}};

struct Layout {
    uint32_t id;
    const char *name;
    bool max_pool; // 2x2 maximum with switches; otherwise 2x2 mean
};
inline constexpr Layout kFlight = {1, "flight", false}, kPaper = {2, "paper", true};

// Returns the layout with this id, or NULL if there is none.
constexpr const Layout *find_layout(uint32_t id) noexcept {
    return id == kFlight.id ? &kFlight : id == kPaper.id ? &kPaper : nullptr;
}

// Index of a tensor in the table. Stages count from 0 at the input.
constexpr size_t conv_weight(size_t stage) noexcept {
    return 2 * stage;
}
constexpr size_t conv_bias(size_t stage) noexcept {
    return 2 * stage + 1;
}
constexpr size_t kLatentWeight = 8, kLatentBias = 9, kExpandWeight = 10, kExpandBias = 11;
constexpr size_t deconv_weight(size_t stage) noexcept {
    return 12 + 2 * (kStages - 1 - stage);
}
constexpr size_t deconv_bias(size_t stage) noexcept {
    return deconv_weight(stage) + 1;
}

// Offset of a tensor in the array of all weights; tensor_offset(kTensors) is the number of weights.
constexpr size_t tensor_offset(size_t tensor) noexcept {
    size_t offset = 0;
    for (size_t i = 0; i < tensor; i++)
        offset += kTensorTable[i].count();
    return offset;
}
constexpr size_t kParameters = tensor_offset(kTensors);

// 64-bit FNV-1a of the layout's name, then of each tensor's name and dimensions (little-endian u32). The weights blob
// stores it, so that a blob of another table is rejected.
constexpr uint64_t layout_hash(const Layout &layout) noexcept {
    const auto text = [](const char *name, uint64_t hash) {
        size_t size = 0;
        while (name[size] != 0)
            size++;
        return fnv1a(name, size, hash);
    };
    uint64_t hash = text(layout.name, kFnvOffset);
    for (const Tensor &tensor : kTensorTable) {
        hash = text(tensor.name, hash);
        for (const uint32_t n : tensor.size) {
            const char bytes[4] = {static_cast<char>(n), static_cast<char>(n >> 8), static_cast<char>(n >> 16),
                                   static_cast<char>(n >> 24)};
            hash = n != 0 ? fnv1a(bytes, 4, hash) : hash;
        }
    }
    return hash;
}

} // namespace toliman::cae
