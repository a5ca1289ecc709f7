// State of a training: everything that its next step depends on except the frames. A training can therefore be
// cancelled, saved and resumed with the same result, bit for bit.
#pragma once
#include <cstddef>
#include <cstdint>

#include "cae/forward.hpp"

namespace toliman::cae {

enum class Mode : uint32_t { tied = 0, unsupervised = 1 };

constexpr uint64_t kMostFrames = 1u << 20; // their inputs fill 256 GiB
constexpr uint32_t kLargestBatch = 4096;

// Settings that must be equal for a training to be resumed. total: number of steps of tied training, over which the
// learning rate falls to 0; frames, validation and batch: of unsupervised training. 0 where they do not apply.
struct Course {
    Mode mode = Mode::tied;
    double learning_rate = 0;
    uint64_t total = 0, frames = 0, validation = 0;
    uint32_t batch = 0;
    bool operator==(const Course &o) const noexcept {
        return mode == o.mode && learning_rate == o.learning_rate && total == o.total && frames == o.frames &&
               validation == o.validation && batch == o.batch;
    }
};

// The caller's array for the loss after each step or epoch; losses beyond its end are dropped.
struct Losses {
    double *values = nullptr;
    uint64_t count = 0;
    void put(uint64_t k, double loss) const noexcept {
        if (k < count)
            values[k] = loss;
    }
};

struct Training {
    explicit Training(const Layout &layout) : weights(layout), first(layout), second(layout) {}
    Course course;
    uint32_t done = 0;  // completed steps (tied) or epochs (unsupervised)
    uint64_t steps = 0; // completed optimiser steps
    double loss = 0, validation_loss = 0;
    Parameters weights;
    Parameters first, second; // optimiser moments: the momentum or Adam's first, and Adam's second (unsupervised only)
};

} // namespace toliman::cae
