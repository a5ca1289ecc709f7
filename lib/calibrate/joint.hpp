// The normal equations of all frames about a point.
#pragma once
#include <memory>

#include "calibrate/planes.hpp"
#include "calibrate/problem.hpp"

namespace toliman::calibrate {

constexpr size_t kChunks = 8; // of frames, each with a sum of its own

// Normal equations of a frame: its own parameters first, then those of the instrument.
struct Block {
    Buffer<double> matrix;   // [size][size], symmetric; the upper triangle
    Buffer<double> gradient; // [size]
    double chi_square = 0, inverse_counts = 0;
    size_t used = 0, saturated = 0;
};

struct Linearisation {
    std::vector<Block> blocks;  // [frame]
    double chi_square = 0;      // of all frames
    double inverse_counts = 0;  // sum over all pixels of 1/expected counts: with 2 per pixel the variance of chi_square
    Buffer<double> of_response; // what an unknown response adds to the covariance of the instrument; empty: nothing
    double separation_sigma_px = 0; // of the mean separation, due to the response and the instrument; with of_response
    double excess = 1;              // of the variances: chi_square per pixel, if it is above 1
    size_t used = 0;                // pixels
    bool lost = false;              // a star left the model images: nothing else is valid
    bool refused = false;           // likewise: the scene is not possible
};

// A frame whitened: residuals over their standard deviations.
struct Whitened {
    size_t frame;
    const double *residual; // [rows][cols], 0 where a pixel saturates or is bad
};

// The fits of the frames of one window at a point; frames are distributed over the workers.
class Joint {
  public:
    // before: that of the window before, whose last fit is the first of this one; NULL makes both.
    Joint(const Problem &problem, const Point &point, size_t window, const Joint *before = nullptr);

    const std::vector<size_t> &frames() const noexcept { return window_.frames; }
    const fit::Fit &first() const noexcept { return *first_; } // at the start of a window with frames
    std::shared_ptr<const fit::Fit> fit_of(size_t frame) const;
    // blend: weight of the counts in the variances, as in fit::Model::linearise(). Adds the blocks of the window's
    // frames to `all`.
    void linearise(const Planes &planes, double blend, Linearisation &all) const;
    // Those of the window's frames, without regard to point.bad, into bad[frame].
    void find_bad_pixels(std::vector<BadPixels> &bad) const;
    // Calls `on_frame` for each of these frames of the window, in their order, with variances of the model.
    void whiten(const std::vector<size_t> &frames, const std::function<void(const Whitened &)> &on_frame) const;

  private:
    std::vector<Block> blocks(size_t first, size_t count, const Planes &planes, double blend) const;
    Block block(size_t frame, const Planes &planes, double blend) const;

    const Problem &problem_;
    const Point &point_;
    const Window &window_;
    std::shared_ptr<const fit::Fit> first_, next_; // at both ends of the window, where its frames need them
};

// About a point, with the derivatives of `planes`.
Linearisation linearise(const Problem &problem, const Point &point, const Planes &planes, double blend);

// Of each frame, at a point; empty if there are none.
std::vector<BadPixels> find_bad_pixels(const Problem &problem, const Point &point);

} // namespace toliman::calibrate
