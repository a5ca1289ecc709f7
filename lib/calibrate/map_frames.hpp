// The frames of a map fit, linearised about a point: products of their derivatives with vectors, and of the adjoint.
#pragma once
#include "calibrate/joint.hpp"
#include "calibrate/map_images.hpp"

namespace toliman::calibrate {

// No frame is read: weights are those of the expected counts.
class MapFrames {
  public:
    // The instrument's parameters of `problem` are those of `planes`. `model` weighs the pixels. All arguments must
    // outlive the object.
    MapFrames(const Problem &problem, const Point &point, const fit::Model &model, const Planes &planes)
        : problem_(problem), point_(point), model_(model), planes_(planes) {}

    // Matrices of the normal equations, without gradients.
    Linearisation matrices() const;
    // Of each frame D'W u: D the derivatives by its own parameters and those of the instrument, W the weights, u the
    // change of the frame by a change of the images.
    std::vector<Buffer<double>> project(const StarSamples &images) const;
    // Sum over frames of the adjoint of `images -> u` of W (u - D d), d a change of all parameters; u = 0 for NULL.
    StarSamples gather(const StarSamples *images, const Point &change) const;

    // The residuals of the counts about the point, which are read: the same for the accurate model.
    struct Residuals {
        std::vector<Buffer<double>> projected; // D'W r of each frame
        StarSamples gathered;                  // sum over frames of the adjoint of W r
        double chi_square = 0;
        size_t used = 0; // pixels
    };
    void add_residuals(const Joint &joint, Residuals &sum) const;

  private:
    class Rows;
    StarSamples samples() const;
    template <class Work> void for_chunks(const Work &work) const;

    const Problem &problem_;
    const Point &point_;
    const fit::Model &model_;
    const Planes &planes_;
};

// a += b
void add(const StarSamples &b, StarSamples &a) noexcept;

} // namespace toliman::calibrate
