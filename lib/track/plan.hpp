// What a tracker is made of: the outcome of a frame, the estimator and the reduction as functions, the plan.
#pragma once
#include <array>
#include <functional>
#include <limits>

#include "base/goodness.hpp"
#include "track/clock.hpp"
#include "track/frame.hpp"
#include "track/ledger.hpp"
#include "track/reduction.hpp"
#include "track/setup.hpp"
#include "track/terms.hpp"

namespace toliman::track {

enum class Verdict : int32_t {
    accepted = 0,
    duplicate = 1,
    quarantined = 2,
    outlier = 3,
    rejected = 4,
    unreduced = 5,
    misfit = 6
};

struct Outcome {
    Verdict verdict = Verdict::rejected;
    Flaw flaw; // rejected and unreduced frames only
    int64_t tai_ns = 0;
    double value = 0;        // frames with a value: reduced if frames are; unreduced frames: that of the estimator
    Goodness goodness;       // of these frames
    uint32_t bad_pixels = 0; // left out of the estimate
    double sigma = 0;        // of the value
};

// Result of an estimator for one image.
struct Estimated {
    double value = std::numeric_limits<double>::quiet_NaN();
    double sigma = 0;                                             // 0: the frame's sigma
    double chi_square = std::numeric_limits<double>::quiet_NaN(); // per pixel, against its model
    double chi_square_sigma = std::numeric_limits<double>::quiet_NaN();
    double largest_residual = std::numeric_limits<double>::quiet_NaN();
    uint32_t bad_pixels = 0;
    uint32_t flags = 0;
    // Further values, covariances and parameters, in the order of Columns; as many as the plan declares columns for.
    std::array<double, kMaxFurther> further = {};
};

// Estimator: computes the value of an image, which it may overwrite. Each worker calls it for one frame at a time. An
// exception, a value that is not finite or a sigma outside the terms' range rejects the frame.
using Estimate =
    std::function<void(double *image, const Frame &frame, int64_t tai_ns, unsigned worker, Estimated &estimated)>;

// Called for a frame that is a misfit, before it is recorded. Returns whether `other` is to be tried in its place: the
// same frame with other pixels, which stay valid until the push ends.
using Retry = std::function<bool(const Frame &frame, const Outcome &outcome, Frame &other)>;

// Grid and salt of the setup are those of the sums and of the ledger.
struct Plan : Setup {
    int64_t capacity = 0; // frames
    Terms terms;
    Columns columns; // of a new ledger; an existing ledger keeps its own
    Retry retry;     // may be empty
    Reduce reduce;   // with a reference: needed to push frames, and to rebuild
    unsigned workers = 1;
    size_t group = 64; // records per write and fsync
    Sync sync = Sync::group;
};

} // namespace toliman::track
