// The prepared scene: computes each image once, when first needed, then makes any frame by index. Const calls may run
// on several threads.
#pragma once
#include <memory>
#include <mutex>
#include <string>

#include "base/progress.hpp"
#include "optics/images.hpp"
#include "optics/light.hpp"
#include "optics/moved.hpp"
#include "optics/plan.hpp"
#include "optics/pupil.hpp"
#include "scene/scene.hpp"

namespace toliman::optics {

// Largest error of images for bounds. With few wavelengths an image has fine structure that the true one has not, which
// makes nuisances seem less alike: at 1e-4, the bound of a scene without mask is 0.6 times the true one.
constexpr double kBoundAccuracy = 1e-9;

struct Settings {
    EngineKind engine = EngineKind::matrix_dft;
    unsigned workers = 0; // 0 = one per processor
    Progress progress;
    Log log;
    std::string bad_pixels; // file that replaces detector.bad_pixels of the scene; "": none does
};

// A validated scene with its pupil, light and plan: all that is known before an image is computed.
struct Outline {
    Scene scene;
    Pupil pupil;
    Light light;
    Plan plan;
};

// The outline of a scene.
Outline outline_of(Scene scene, const Settings &settings);
// The same of a scene in JSON text; messages name it `source`, and its relative file names start at `folder`.
Outline outline_of(const std::string &json, const std::string &source, const std::string &folder,
                   const Settings &settings);
// The same of a scene file, whose relative file names start at its own folder.
Outline outline_of(const std::string &path, const Settings &settings);

class Simulator {
  public:
    Simulator(Outline outline, const Settings &settings);
    ~Simulator();
    Simulator(const Simulator &) = delete; // its imager refers to its other members
    Simulator &operator=(const Simulator &) = delete;

    const Scene &scene() const noexcept { return scene_; }
    const Pupil &pupil() const noexcept { return pupil_; }
    const Light &light() const noexcept { return light_; }
    const Plan &plan() const noexcept { return plan_; }
    const DetectorStages &detector() const noexcept { return detector_; }
    const Images &images() const noexcept { return images_; }
    // The images that bounds are computed from: those of the scene, or of the same scene at kBoundAccuracy if that is
    // finer. Computed by the first call.
    const Images &bound_images() const;
    // Predicted error of the expansion in the displacement, relative to the signal's largest pixel.
    double truncation() const;
    size_t pixels() const noexcept { return scene_.detector.rows * scene_.detector.cols; }

    // Largest |displacement| that a frame may have.
    double largest_displacement_px() const noexcept {
        return plan_.frames == Frames::series ? kLargestDisplacement : kFarthestDisplacement;
    }
    double min_displacement_px() const noexcept { return min_displacement_; }
    double max_displacement_px() const noexcept { return max_displacement_; }

    double time_days(int64_t k) const noexcept; // of frame k; beyond a list of times, its last entry
    double displacement_px(int64_t k) const noexcept;

    // Expected electrons at a displacement, into image[rows][cols]: by propagating every wavelength, ...
    void propagate(double displacement_px, double *image) const;
    // ... or by the Taylor expansion in the displacement.
    void expect(double displacement_px, double *image) const;
    // Frame k with its systematics, detector stages and noise; scratch and image hold pixels() values each.
    void frame(double displacement_px, uint64_t seed, int64_t k, double *scratch, double *image) const;
    // Frame k of these expected electrons, which are overwritten.
    void expose(uint64_t seed, int64_t k, double *electrons, double *image) const;

  private:
    Buffer<double> star_at(const Light &light, size_t star, double displacement_px) const;

    Scene scene_;
    Pupil pupil_;
    Light light_;
    Plan plan_;
    Imager imager_;
    DetectorStages detector_;
    Images images_;
    MovedStars moved_;
    double min_displacement_ = 0, max_displacement_ = 0; // of the signal over the cadence
    const Memory memory_ = current_memory();
    mutable std::mutex mutex_;
    struct Fine;
    mutable std::unique_ptr<Fine> fine_;
};

} // namespace toliman::optics
