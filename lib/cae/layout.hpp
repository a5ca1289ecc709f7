// Network layouts as constexpr tables: stages, tensors, offsets and layout hash.
//
// The encoder has four stages, 256x256x1 -> 128x128x8 -> 64x64x16 -> 32x32x32 -> 16x16x64 (`core`: 128x128x1 -> ... ->
// 8x8x64), and a dense layer to one latent. The decoder mirrors it. All layouts have the same tensors, in the order in
// which the weights blob stores them (tools/docs/formats.md). They differ in size and in how a stage changes
// resolution:
//
//     flight, core  down: 3x3 convolution, 2x2 mean, ELU      up: nearest up-sampling x2, 3x3 deconvolution, ELU
//     paper         down: 3x3 convolution, 2x2 maximum (switches), ELU
//                   up: un-pooling with the switches, deconvolution, ELU
//
// The decoder's last stage is linear (no ELU). "Deconvolution" is the transposed convolution.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/hash.hpp"
#include "kernels/conv.hpp"

namespace toliman::cae {

constexpr size_t kStages = 4;
constexpr std::array<size_t, kStages + 1> kChannels = {1, 8, 16, 32, 64}; // of the images, from the input on
constexpr size_t kDeepChannels = kChannels[kStages];
constexpr size_t kLargestSide = 256; // rows and columns of the largest input

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

// Convolution kernels are [coarse][fine][3][3] in encoder and decoder; dense weights are [row][col][channel]. deep:
// rows and columns of the features.
constexpr size_t kTensors = 20;
using TensorTable = std::array<Tensor, kTensors>;
constexpr TensorTable tensor_table(uint32_t deep) noexcept {
    return {{{"conv1.weight", {8, 1, 3, 3}},      {"conv1.bias", {8}},
             {"conv2.weight", {16, 8, 3, 3}},     {"conv2.bias", {16}},
             {"conv3.weight", {32, 16, 3, 3}},    {"conv3.bias", {32}},
             {"conv4.weight", {64, 32, 3, 3}},    {"conv4.bias", {64}},
             {"latent.weight", {deep, deep, 64}}, {"latent.bias", {1}},
             {"expand.weight", {deep, deep, 64}}, {"expand.bias", {deep, deep, 64}},
             {"deconv4.weight", {64, 32, 3, 3}},  {"deconv4.bias", {32}},
             {"deconv3.weight", {32, 16, 3, 3}},  {"deconv3.bias", {16}},
             {"deconv2.weight", {16, 8, 3, 3}},   {"deconv2.bias", {8}},
             {"deconv1.weight", {8, 1, 3, 3}},    {"deconv1.bias", {1}}}};
}

struct Layout {
    uint32_t id;
    const char *name;
    size_t side;   // rows and columns of the network's input
    bool max_pool; // 2x2 maximum with switches; otherwise 2x2 mean
    TensorTable tensors;
    std::array<size_t, kTensors + 1> offsets;       // of the tensors in the array of all weights; the last: its size
    std::array<kernels::ConvShape, kStages> shapes; // of the stages, from the input to the features

    constexpr Layout(uint32_t number, const char *word, size_t input_side, bool maximum) noexcept
        : id(number), name(word), side(input_side), max_pool(maximum),
          tensors(tensor_table(static_cast<uint32_t>(input_side >> kStages))), offsets(), shapes() {
        for (size_t i = 0; i < kTensors; i++)
            offsets[i + 1] = offsets[i] + tensors[i].count();
        for (size_t s = 0; s < kStages; s++)
            shapes[s] = {side >> (s + 1), side >> (s + 1), kChannels[s], kChannels[s + 1]};
    }

    constexpr size_t pixels() const noexcept { return side * side; }
    constexpr size_t deep_side() const noexcept { return side >> kStages; } // rows and columns of the features
    constexpr size_t features() const noexcept { return deep_side() * deep_side() * kDeepChannels; }
    constexpr size_t parameters() const noexcept { return offsets[kTensors]; }
    // Floats of the bordered image at a level: level 0 is the network's input or output, level kStages the features.
    constexpr size_t level_size(size_t level) const noexcept {
        return level < kStages ? shapes[level].fine() : shapes[kStages - 1].coarse();
    }
    constexpr size_t input_stride() const noexcept { return side + 2; } // floats per row of level 0
    // Of the first pixel of a row inside the border, of level 0 and of the features.
    constexpr size_t input_at(size_t row) const noexcept { return (row + 1) * input_stride() + 1; }
    constexpr size_t feature_at(size_t row) const noexcept {
        return ((row + 1) * (deep_side() + 2) + 1) * kDeepChannels;
    }
};
inline constexpr Layout kFlight(1, "flight", 256, false), kPaper(2, "paper", 256, true), kCore(3, "core", 128, false);
inline constexpr std::array<const Layout *, 3> kLayouts = {&kFlight, &kPaper, &kCore};

// Returns the layout with this id, or NULL if there is none.
constexpr const Layout *find_layout(uint32_t id) noexcept {
    for (const Layout *layout : kLayouts)
        if (layout->id == id)
            return layout;
    return nullptr;
}

// The default for frames of this size.
constexpr const Layout &default_layout(size_t rows, size_t cols) noexcept {
    return std::min(rows, cols) < kFlight.side ? kCore : kFlight;
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
    for (const Tensor &tensor : layout.tensors) {
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
