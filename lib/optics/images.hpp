// The images of a scene: stars and reference frame at once, derivatives when first needed; in expected electrons per
// frame (photons, where the detector has no qe).
#pragma once
#include <map>
#include <mutex>
#include <optional>

#include "base/buffer.hpp"
#include "base/memory.hpp"
#include "base/progress.hpp"
#include "optics/derivatives.hpp"
#include "optics/detector.hpp"
#include "optics/imager.hpp"

namespace toliman::optics {

constexpr double kMostPhotons = 1e12; // per pixel: the range of the Poisson generator

// Derivatives of the reference frame by the displacement, of order 1, 2, ...; one order more than the expansion uses,
// to predict its truncation.
using Motion = std::vector<Buffer<double>>;

// Derivatives of the reference frame by everything else.
struct Disturbed {
    Buffer<double> shift_x, shift_y; // by a common shift of both stars, per px
    Buffer<double> roll;             // by a roll of the sky about the frame's centre, from x towards y, per rad
    Buffer<double> scale;            // by a relative scale of the whole image about the frame's centre
    Buffer<double> focus;            // by defocus, per nm rms
    Buffer<double> background;       // by uniform light, per photon in each pixel
};

// All images are [rows][cols]. Any number of threads may use the const functions at once; while the first call computes
// derivatives, the others wait. The bits of an image do not depend on which others were computed before.
class Images {
  public:
    // Propagates both stars, and at once the derivatives by the displacement up to this order. If the scene gives the
    // peak in photons, scales all images and `light` to it. All arguments but light and progress must outlive the
    // object.
    Images(const Scene &scene, const Pupil &pupil, const Imager &imager, const Plan &plan,
           const DetectorStages &detector, Light &light, const Progress &progress, size_t order = 0);

    const Buffer<double> &star(size_t s) const noexcept { return star_[s]; } // B empty for a single star
    const Buffer<double> &both() const noexcept { return both_; } // reference frame: no displacement, with dark current
    const Buffer<double> &variance() const noexcept {
        return variance_;
    }                                                              // of a frame, electrons^2, > 0;
                                                                   // infinite for bad pixels
    double peak_photons() const noexcept { return peak_photons_; } // brightest pixel before the detector
    double total_photons() const noexcept { return total_photons_; }

    const Motion &motion() const;       // only up to the order of the constructor, if that was above 0
    const Disturbed &disturbed() const; // if motion() is missing too, both cost one propagation

    // The derivative by a parameter with an own derivative (optics/derivatives.hpp), per unit. prepare() computes those
    // that are missing at once, which costs less; parameters without an own derivative are skipped.
    const Buffer<double> &derivative(Parameter parameter) const;
    void prepare(const std::vector<Parameter> &parameters) const;

    // The derivative of sum over pixels of weights [rows][cols] times both() by the OPD of each pupil cell (m), [N][N],
    // with the photons of the stars unchanged. Status::unsupported for the padded FFT.
    Buffer<double> opd_gradient(Buffer<double> weights) const;

  private:
    void propagate(bool motion, bool disturbed) const;
    void set_motion(StarImages &star) const;
    void finish(Buffer<double> &image) const;

    const Scene &scene_;
    const Pupil &pupil_;
    const Imager &imager_;
    const Plan &plan_;
    const DetectorStages &detector_;
    const Light light_; // before the scaling to the peak
    const Memory memory_ = current_memory();
    double factor_ = 1; // of the scaling to the peak
    Buffer<double> star_[2], both_, variance_;
    double peak_photons_ = 0, total_photons_ = 0;
    mutable std::mutex mutex_;
    mutable std::optional<Motion> motion_;
    mutable std::optional<Disturbed> disturbed_;
    mutable std::map<Parameter, Buffer<double>> derivatives_;
};

// The derivative image of a parameter, also of those that have no own derivative.
const Buffer<double> &image_of(const Images &images, Parameter parameter);

} // namespace toliman::optics
