// A fit whose optics change with time: that of a scene at the start of each window, and of their interpolation between.
#pragma once
#include <memory>
#include <vector>

#include "fit/fit.hpp"

namespace toliman::fit {

// Const calls may run on several threads, each with its own work.
class Windows {
  public:
    // first_days [scenes.size()], the increasing starts of the windows. Status::mismatch unless the frames, stars and
    // cadences of all scenes are the same; otherwise as Fit.
    Windows(const std::vector<const optics::Simulator *> &simulators, const double *first_days,
            const std::vector<Parameter> &free, double capture_px, unsigned workers, const Progress &progress);

    // The fit of frames at this time: between those of the windows that start before and after it; before the first
    // start and after the last one, that of the window which starts there.
    std::shared_ptr<const Fit> at(double days) const;
    // The same for the sums of frames, if the prediction is that of one.
    std::shared_ptr<const Fit> at(const Prediction &prediction) const;
    const Fit &first() const noexcept { return *fits_.front(); }
    const Fit &window(size_t i) const noexcept { return *fits_[i]; }
    size_t count() const noexcept { return fits_.size(); }

    FitWork work() const; // for all windows
    void frame(ImageView<const double> counts, const Prediction &prediction, FitWork &work, Result &result) const {
        at(prediction)->frame(counts, prediction, work, result);
    }

    // What all windows have in common.
    const std::vector<Parameter> &parameters() const noexcept { return first().parameters(); }
    size_t rows() const noexcept { return first().rows(); }
    size_t cols() const noexcept { return first().cols(); }
    double capture_px() const noexcept { return first().capture_px(); }
    size_t images() const noexcept;   // model images of all windows
    uint64_t digest() const noexcept; // of all windows and their starts; of one window, that of its fit

  private:
    std::vector<double> first_days_;
    std::vector<std::shared_ptr<const Fit>> fits_;
};

} // namespace toliman::fit
