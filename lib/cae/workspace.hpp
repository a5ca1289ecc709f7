// Working memory of encoding.
#pragma once
#include <optional>
#include <vector>

#include "cae/encoder_rows.hpp"
#include "cae/preprocess.hpp"

namespace toliman::cae {

// Working memory of one thread; reuse it to avoid allocations.
struct Workspace {
    Preprocess::Work input;
    std::vector<EncoderRows> rows; // with mean pooling, one per frame
    std::optional<Images> images;  // with maximum pooling, whose switches need whole images
    Buffer<double> repaired;       // crop of a frame with bad pixels, counts [pixels]; allocated for the first one

    // Allocates what `frames` frames need that are encoded together, always by a network of the same layout.
    void prepare(const Layout &layout, size_t frames) {
        input.reserve(layout.pixels(), frames);
        if (layout.max_pool && !images)
            images.emplace(layout);
        while (!layout.max_pool && rows.size() < frames)
            rows.emplace_back(layout);
    }
};

} // namespace toliman::cae
