// The frames of a response fit, linearised about a point, with the parameters of each frame eliminated.
#pragma once
#include "calibrate/joint.hpp"

namespace toliman::calibrate {

// The derivative of pixel i of frame k by the relative change d_i of its response is a_ki = light/(1 + d_i), in photons
// as those by all other parameters. With A_k = W a J, J the derivatives by the frame's own parameters, F_k = J'WJ.
class ResponseFrames {
  public:
    // The joint of the only window. All arguments must outlive the object.
    ResponseFrames(const Problem &problem, const Point &point, const Joint &joint)
        : problem_(problem), point_(point), joint_(joint) {}

    struct Equations {
        Linearisation normal;                   // of all other parameters
        Buffer<double> separation;              // mean over frames of A_k F_k^-1 h_k, h_k that of the separation by t_k
        std::vector<double> separation_gain;    // mean over frames of h_k' F_k^-1 J'W G
        Buffer<double> diagonal;                // sum over frames of W a^2
        Buffer<double> gradient;                // W a r, r the residual, after elimination
        Buffer<double> eliminated;              // the diagonal of the sum of A_k F_k^-1 A_k'
        std::vector<Buffer<double>> instrument; // by each parameter of the instrument: W a G, after elimination
        bool solvable = true;
    };
    Equations linearise(const Planes &planes);

    using Projections = std::vector<std::array<double, kOwn>>; // of each frame
    // The sum over frames of A_k F_k^-1 A_k' v; projections: A_k' v. After linearise().
    Buffer<double> product(const Buffer<double> &v, Projections &projections) const;

  private:
    class Rows;
    static void accumulate(const Rows &rows, const std::array<double, kOwn * kOwn> &inverse, const Buffer<double> &gain,
                           Equations &sum);
    static void accumulate_separation(const Rows &rows, const std::array<double, kOwn> &gradient,
                                      const std::array<double, kOwn * kOwn> &inverse, const Buffer<double> &gain,
                                      Equations &sum);
    template <class Work> void for_chunks(const Work &work) const;

    const Problem &problem_;
    const Point &point_;
    const Joint &joint_;
    std::vector<std::array<double, kOwn * kOwn>> inverse_; // F_k^-1
};

} // namespace toliman::calibrate
