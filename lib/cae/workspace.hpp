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
    std::vector<EncoderRows> rows; // of layout `flight`, one per frame
    std::optional<Images> images;  // of layout `paper`, whose switches need whole images
    Buffer<double> repaired;       // crop of a frame with bad pixels, counts [kPixels]; allocated for the first one

    // Allocates what `frames` frames need that are encoded together.
    void prepare(const Layout &layout, size_t frames) {
        input.reserve(frames);
        if (layout.max_pool && !images)
            images.emplace();
        while (!layout.max_pool && rows.size() < frames)
            rows.emplace_back();
    }
};

} // namespace toliman::cae
