// What a mask design minimises: the Cramer-Rao bound of the separation with nuisances free, and its gradient by the
// fraction of each pupil cell that the mask covers.
#pragma once
#include <vector>

#include "mask/score.hpp"

namespace toliman::mask {

// What a mask must not exceed, and how much it costs if it does.
struct Limit {
    double frame_pixels = 0;   // of the whole frame, if the scene has a part of it
    double peak_to_mean = 0;   // largest: brightest pixel over the mean of frame_pixels
    double peak_weight = 0;    // of sum over pixels of max(0, ln(pixel/limit))^2
    double light_in_frame = 0; // smallest
    double light_weight = 0;   // of max(0, ln(limit/light))^2
};

struct Merit {
    double loss = 0;           // ln(bound/px) + penalties
    double bound_px = 0;       // infinite if the frame does not constrain the separation
    double peak_to_mean = 0;   // brightest pixel over the mean of frame_pixels
    double light_in_frame = 0; // fraction of the stars' photons
};

class Objective {
  public:
    // free: nuisances, of flux_a, flux_b, shift_x, shift_y, roll, scale, focus, background. step_m: OPD of the mask's
    // step; the scene's own mask does not count. Status as for a simulator, and Status::unsupported for other
    // nuisances and for the padded FFT.
    Objective(const Scene &scene, const std::vector<Parameter> &free, double step_m, unsigned workers);
    Objective(const Objective &) = delete; // its imager refers to its other members
    Objective &operator=(const Objective &) = delete;

    size_t samples() const noexcept { return outline_.pupil.samples; }
    const Buffer<double> &amplitude() const noexcept { return outline_.pupil.amplitude; } // of each cell
    size_t wavelengths() const noexcept { return outline_.plan.wavelengths; }

    // Of a mask that covers these fractions, in [0, 1], of the cells [samples][samples]. gradient [samples][samples] of
    // the loss, 0 in closed cells, or nullptr. The bits do not depend on the workers.
    Merit evaluate(const Buffer<double> &covered, const Limit &limit, Buffer<double> *gradient);

    // The scores of the mask, with the true peak where evaluate() has a smooth one. frame_pixels as in Limit.
    Score judge(const Buffer<double> &covered, double frame_pixels);

  private:
    // The images of one mask. Weights are derivatives of the loss by the electrons of the images.
    struct Work {
        optics::StarImages star[2];
        Buffer<double> light; // photons of both stars, before the factor
        double factor = 1;    // of the photons, in a scene that gives the peak
        double gradient_energy = 0;
        Buffer<double> variance;             // e^2
        std::vector<Buffer<double>> columns; // derivative images J_i
        std::vector<double> solution;        // x
        Buffer<double> score;                // -r/(V s^2)
        Buffer<double> by_light;             // weights of the stars' images: through variance, factor and penalty
    };
    void set_mask(const Buffer<double> &covered);
    void render(double order, Work &work) const;
    void inform(const std::vector<Parameter> &free, Work &work) const;
    double bound_with(const std::vector<Parameter> &free);
    void weigh(const Limit &limit, Work &work, Merit &merit) const;
    Buffer<double> gradient_of(const Work &work) const;

    optics::Outline outline_;
    std::vector<Parameter> free_;
    Buffer<double> plain_opd_m_; // of the cells without the mask
    optics::Imager imager_;
    optics::DetectorStages detector_;
    Buffer<double> response_; // of each pixel, electrons per photon
    double photons_ = 0;      // of the stars
    Work work_;               // kept for its memory
};

} // namespace toliman::mask
