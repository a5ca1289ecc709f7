// A scene as JSON with a place for other masks, and what the library says of it with one of them.
#pragma once
#include <limits>
#include <string>

#include <toliman/toliman.hpp>

#include "common/json.hpp"
#include "scenes/spiral.hpp"

namespace cli {

struct Score {
    double crb_px = std::numeric_limits<double>::infinity();       // Cramer-Rao bound of the separation, all else known
    double peak_to_mean = std::numeric_limits<double>::infinity(); // of the noise-free frame
    double light_in_frame = 0;                                     // part of the stars' photons
};

Score score_of(const toliman_sim *sim);

class MaskedScene {
  public:
    // A scene file that the library has read as `sim`.
    MaskedScene(const std::string &path, const toliman_sim *sim);

    const std::string &folder() const noexcept { return folder_; }
    const cJSON *own_mask() const noexcept; // nullptr if it has none
    JsonTree mask(const Terms &terms) const;
    // The scene with a spiral mask of these terms, or with its own if there are none.
    JsonTree with(const Terms &terms) const;

    // Judges a mask on one thread; may be called from several at once.
    Score judge(const Terms &terms) const;

    // What is as good for judging and quicker: no signal, whose size the bound does not depend on.
    MaskedScene without_signal() const;
    // What ranks masks nearly alike at a fraction of the time: few wavelengths and, where the library accepts it, half
    // the pupil samples.
    MaskedScene sketch() const;

  private:
    MaskedScene(const MaskedScene &other);
    bool accepted() const;

    JsonTree scene_;
    std::string folder_;
    std::string step_ = "opd_nm"; // or height_nm, of every mask
    double step_nm_ = 0;
};

} // namespace cli
