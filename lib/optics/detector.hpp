// Detector model, from expected photons to counts:
//     photons x qe x flat + dark -> Poisson -> full well -> + read noise -> / gain + bias -> integers of bit_depth bits
// Stages that the scene does not name are skipped and cost nothing.
#pragma once
#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "scene/scene.hpp"

namespace toliman::optics {

enum class Quantity { frame, derivative, variance };
enum class Unit { photon, electron, dn };

class DetectorStages {
  public:
    explicit DetectorStages(const Scene &scene);

    // Converts expected photons, or their derivatives, to electrons: multiplies by qe and flat, adds no dark current.
    void apply_response(double *image) const noexcept;          // [pixels]
    void apply_response(Buffer<double> &image) const noexcept { // none of an absent star
        if (!image.empty())
            apply_response(image.data());
    }
    double dark_e() const noexcept { return dark_e_; } // per pixel and frame
    // Variance that the detector adds to the Poisson variance: read noise and rounding to integers.
    double added_variance_e2() const noexcept;

    // Given     expected electrons [pixels]; overwritten
    // Returned  image [pixels]: frame number `frame` of this seed, in the frame's unit
    void detect(uint64_t seed, uint64_t frame, double *expected, double *image) const noexcept;

    // Converts an image of electrons to the frame's unit (DN, or unchanged), in place or as a copy.
    void to_counts(Quantity quantity, double *image) const noexcept;
    Buffer<double> in_counts(Buffer<double> image, Quantity quantity) const noexcept;
    double counts_of(double electrons) const noexcept { return electrons / e_per_count_ + bias_; }
    double electrons_of(double counts) const noexcept { return (counts - bias_) * e_per_count_; }
    double e_per_count() const noexcept { return e_per_count_; }
    double bias() const noexcept { return bias_; }
    double saturation_e() const noexcept; // least electrons of a pixel that saturates; infinite if none does
    Unit unit() const noexcept;
    bool whole_counts() const noexcept;

    // Warns where a noise-free frame exceeds the full well or the bit depth, or where read noise may be clipped at 0
    // DN. `about` is put in front of numbers of pixels ("about " for a rough image).
    void warn(const Buffer<double> &electrons, const char *about, const std::string &source, const Log &log) const;

  private:
    size_t pixels_;
    bool photon_noise_, has_qe_;
    Buffer<double> response_; // electrons per photon; empty if all are 1
    double dark_e_, read_e_;
    double full_well_e_; // of all coadds together; infinite if the scene names none
    double e_per_count_, bias_;
    double largest_count_; // 0 = counts are not rounded
};

} // namespace toliman::optics
