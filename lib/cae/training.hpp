// Where a training stands: all that its next step depends on, but for the frames. So it can be cancelled, saved and
// taken up with the same result.
#pragma once
#include <cstddef>
#include <cstdint>

#include "cae/forward.hpp"

namespace toliman::cae {

enum class Mode : uint32_t { tied = 0, unsupervised = 1 };

constexpr uint64_t kMostFrames = 1u << 20; // 256 GiB of input
constexpr uint32_t kLargestBatch = 4096;

// What must be the same for a training to be taken up. total: the steps of tied training, whose rate falls until then;
// the rest but the rate is of unsupervised training; 0 in the other.
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

// The caller's array for the loss after each step or epoch, as far as it goes.
struct Losses {
    double *values = nullptr;
    uint64_t count = 0;
    void put(uint64_t k, double loss) const noexcept {
        if (k < count)
            values[k] = loss;
    }
};

struct Training {
    Course course;
    uint32_t done = 0;  // steps of tied, epochs of unsupervised training
    uint64_t steps = 0; // of the optimiser
    double loss = 0, validation_loss = 0;
    Parameters weights, first, second; // the latter: moments of the optimiser, the second of unsupervised training
};

} // namespace toliman::cae
