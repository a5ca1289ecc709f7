// A scene as JSON whose mask can be replaced, and its evaluation by the library with a given mask.
#pragma once
#include <limits>
#include <string>

#include "common/json.hpp"
#include "scenes/scene.hpp"
#include "scenes/spiral.hpp"

namespace cli {

struct Score {
    double crb_px = std::numeric_limits<double>::infinity();       // Cramer-Rao bound of the separation, all else known
    double peak_to_mean = std::numeric_limits<double>::infinity(); // of the noise-free frame
    double light_in_frame = 0;                                     // fraction of the stars' photons
};

Score score_of(const Scene &scene);

class MaskedScene {
  public:
    explicit MaskedScene(const Scene &scene);

    const cJSON *own_mask() const noexcept; // nullptr if it has none
    JsonTree mask(const Terms &terms) const;
    // The scene with a spiral mask of these terms, or with its own mask if there are no terms.
    JsonTree with(const Terms &terms) const;

    // Evaluates a mask on one thread; may be called from several threads at once.
    Score evaluate(const Terms &terms) const;

    // The scene without signal, which is faster to evaluate: the bound does not depend on the amplitude.
    MaskedScene without_signal() const;
    // A coarse scene, which ranks masks nearly alike in a fraction of the time: few wavelengths and, if the library
    // accepts it, half the pupil samples.
    MaskedScene coarse() const;

  private:
    MaskedScene(const MaskedScene &other);
    bool accepted() const;

    JsonTree scene_;
    std::string path_;
    std::string step_ = "opd_nm"; // or height_nm, of every mask
    double step_nm_ = 0;
};

} // namespace cli
