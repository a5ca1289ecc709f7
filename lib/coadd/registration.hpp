// Registration of a frame on the model, and the pixels that are left out of a sum.
#pragma once
#include <array>

#include "coadd/table.hpp"

namespace toliman::coadd {

constexpr size_t kMostLeftOut = 256; // pixels of a frame

enum class Verdict { added, next, lost, faint, not_found, outside, misfit };

struct Registered {
    Verdict verdict = Verdict::added;
    double flux = 0, x = 0, y = 0;  // relative flux; px from the predicted place
    double xx = 0, xy = 0, yy = 0;  // covariance of x and y
    double chi_square = 0;          // per degree of freedom, without the pixels that are left out
    size_t left_out = 0, saturated = 0; // pixels; those that are saturated among them
    std::array<uint32_t, kMostLeftOut> pixels;
    std::array<float, kMostLeftOut> expected; // counts of these
};

// Const calls may run on several threads, each with its own work.
class Registration {
  public:
    // Starts no more than the fit needs; frames of fit.rows() x fit.cols().
    Registration(const fit::Fit &fit, const fit::Prediction &prediction, int range, double most_chi_square,
                 unsigned workers, const Progress &progress);

    struct Work {
        Buffer<uint32_t> columns;
    };
    Work work() const { return {Buffer<uint32_t>(cols_)}; }

    // Depends on the counts only. A frame without a verdict other than `added` has all numbers.
    void frame(const kernels::CoaddFrame &frame, Work &work, Registered &out) const noexcept;

    double photons() const noexcept { return photons_; } // of a frame at the predicted place
    size_t bytes() const noexcept { return table_.bytes(); }

  private:
    struct Estimate {
        double flux, x, y;
    };
    struct Solution {
        Estimate step; // flux; x and y times flux
        double covariance[3][3], chi_square;
        bool found;
    };
    Estimate start(const kernels::CoaddFrame &frame, Work &work, size_t *zero_rows) const noexcept;
    void centroid(const kernels::CoaddFrame &frame, Work &work, double *moments, size_t *zero_rows) const noexcept;
    Solution solve(const kernels::CoaddFrame &frame, const Cell &cell, double flux, size_t step,
                   const Registered *left_out) const noexcept;
    bool approach(const kernels::CoaddFrame &frame, Estimate &at) const noexcept;
    bool finish(const kernels::CoaddFrame &frame, Estimate &at, Registered &out) const noexcept;
    kernels::CoaddPixels pixels(const fit::Model &model);
    void calibrate(const fit::Fit &fit, const fit::Prediction &prediction);

    Table table_;
    size_t rows_, cols_;
    double most_chi_square_;
    Buffer<float> gain_, offset_, spread_, added_;
    kernels::CoaddPixels pixels_;
    std::vector<uint32_t> bad_; // pixels of the scene that are not used
    size_t used_ = 0;           // the others
    size_t dark_rows_ = 0;      // rows whose counts may all be 0
    double photons_ = 0, counts_per_photon_ = 0, base_ = 0; // base: counts of a pixel without light
    uint16_t top_ = 0;
    double total_ = 0, centre_[2] = {}, inverse_[2][2] = {}; // of the counts of the stars; px per px of the centroid
};

} // namespace toliman::coadd
