// Sums of registered frames.
#pragma once
#include <memory>

#include "coadd/intervals.hpp"
#include "coadd/moments.hpp"
#include "coadd/registration.hpp"

namespace toliman::coadd {

// Why a frame belongs to the next sum.
enum class End { none, time, gap, motion, full, source };

struct Limits {
    int range = 4;                // px
    double most_chi_square = 1.5; // per degree of freedom
    int64_t duration_ns = 0;      // 0: none
    bool aligned = false;         // at multiples of the duration
    int64_t gap_ns = 0;           // 0: none
    double motion_px = 0;         // 0: none
    int64_t pause_ns = 10000000000;
};

struct Frame {
    kernels::CoaddFrame pixels;
    const char *session, *roi;
    int64_t middle_ns, exposure_ns; // by the camera clock
    int64_t dropped;
    int64_t window_row, window_col;
};

constexpr size_t kMostName = 64;                       // characters
constexpr size_t kVerdicts = 7;                        // of Verdict
int64_t mean_ns(const struct Totals &totals) noexcept; // weighted by photons, of a sum with frames; rounded to 1 ns

// What a sum has in addition to its pixels.
struct Totals {
    char session[kMostName + 1] = {}, roi[kMostName + 1] = {};
    int64_t window_row = 0, window_col = 0;
    int64_t frames = 0, photons = 0, dropped = 0;
    int64_t verdicts[kVerdicts] = {};       // frames with each, since the sum began
    int64_t cosmic_rays = 0, saturated = 0; // pixels of all frames
    Wide photon_ns = 0;                     // sum of photons times time
    Moments moments;
    WeightedSum chi_square, flux; // of frames
    Intervals intervals;
    double first_place[2] = {}, recent_place[2] = {}; // px: mean of the first kRecent frames, and of the last ones
};

class Coadd {
  public:
    Coadd(std::shared_ptr<const fit::Fit> fit, const fit::Prediction &prediction, const Limits &limits,
          unsigned workers, const Progress &progress);

    // Registers a frame and adds it. If the result is `next`, *end says why, and nothing has changed: the sum must be
    // taken first.
    void add(const Frame &frame, Registered &out, End &end) noexcept;

    // Ends the sum, which becomes taken(), and begins the next one.
    void take() noexcept;

    const Totals &totals() const noexcept { return totals_; }
    const Limits &limits() const noexcept { return limits_; }
    struct Taken {
        Totals totals;
        Buffer<uint32_t> counts;   // with those that are expected where pixels were left out, rounded
        Buffer<uint32_t> left_out; // frames in which each pixel was
        int64_t number;            // of the sum, from 0
    };
    const Taken &taken() const noexcept { return taken_; }

    int64_t number() const noexcept { return number_; } // of the sum that is added to
    size_t rows() const noexcept { return fit_->rows(); }
    size_t cols() const noexcept { return fit_->cols(); }
    double photons_per_frame() const noexcept { return registration_.photons(); }
    size_t bytes() const noexcept;
    uint64_t digest() const noexcept { return digest_; }

    // Bytes from which another object for the same fit, prediction and limits continues ("TLMA" of formats.md).
    size_t saved_size() const noexcept;
    std::vector<uint8_t> save() const;
    void load(const void *bytes, size_t size);

  private:
    End end_before(const Frame &frame) const noexcept;
    void add_place(const Registered &found) noexcept;
    void add_pixels(const kernels::CoaddFrame &frame, const Registered &found) noexcept;
    void flush() noexcept;

    std::shared_ptr<const fit::Fit> fit_;
    Limits limits_;
    Registration registration_;
    uint64_t digest_;
    int64_t number_ = 0;
    Totals totals_;
    Taken taken_;
    uint32_t unflushed_ = 0, largest_ = 0; // frames in recent_; largest sum of a pixel
    Buffer<uint32_t> recent_, counts_, left_out_;
    Buffer<int64_t> filled_; // expected counts where pixels were left out, times 2^kFillBits
};

} // namespace toliman::coadd
