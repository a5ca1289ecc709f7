// Detector model, from expected photons to counts:
//     photons x qe x flat x response + smear + dark -> Poisson -> exchange -> full well -> coupling
//     -> non-linearity -> + read noise -> / gain + bias -> integers of bit_depth bits
// (readout.hpp). Images are in electrons before exchange unless said otherwise; estimators undo what
// comes after.
// Stages that the scene does not name are skipped and cost nothing.
#pragma once
#include <limits>

#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "optics/readout.hpp"
#include "scene/scene.hpp"

namespace toliman::optics {

enum class Quantity { frame, derivative, variance };
enum class Unit { photon, electron, dn };

class DetectorStages {
  public:
    explicit DetectorStages(const Scene &scene);

    // Electrons per photon of each pixel: multiplies by qe and flat.
    void apply_response(double *image) const noexcept; // [pixels]
    // Converts expected photons, or their derivatives, to electrons: response and smear, without dark current.
    void collect(double *image) const;
    void collect(Buffer<double> &image) const { // none of an absent star
        if (!image.empty())
            collect(image.data());
    }
    // The adjoint of collect().
    void spread(double *weights) const;
    const Readout &readout() const noexcept { return readout_; }
    double dark_e() const noexcept { return dark_e_; } // per pixel and frame
    // Variance that the detector adds to the Poisson variance: read noise and rounding to integers.
    double added_variance_e2() const noexcept;

    // Given     expected electrons [pixels]; overwritten
    // Returned  image [pixels]: frame number `frame` of this seed, in the frame's unit
    void detect(uint64_t seed, uint64_t frame, double *expected, double *image) const;

    // Converts an image of electrons to what is read, in the frame's unit (DN, or unchanged), in place or as a copy.
    // charge: the frame of which the image is a derivative or variance.
    void to_counts(double *charge) const;
    void to_counts(Quantity quantity, const Buffer<double> &charge, double *image) const;
    Buffer<double> in_counts(Buffer<double> charge) const;
    Buffer<double> in_counts(Quantity quantity, const Buffer<double> &charge, Buffer<double> image) const;
    // The adjoint of the conversion of derivatives.
    void weights_to_charge(const Buffer<double> &charge, double *weights) const;
    // The inverse for a frame: counts of an ideal detector.
    void undo_counts(double *counts) const { readout_.undo_counts(e_per_count_, bias_, saturation_e(), counts); }
    // The inverse of to_counts(), which does not saturate.
    void undo_expected(double *counts) const {
        readout_.undo_counts(e_per_count_, bias_, std::numeric_limits<double>::infinity(), counts);
    }
    // Of a pixel among equal ones.
    double counts_of(double electrons) const noexcept { return readout_.bent(electrons) / e_per_count_ + bias_; }
    double electrons_of(double counts) const noexcept { return readout_.straight((counts - bias_) * e_per_count_); }
    double e_per_count() const noexcept { return e_per_count_; }
    double bias() const noexcept { return bias_; }
    double saturation_e() const noexcept; // least electrons of a pixel that saturates; infinite if none does
    Unit unit() const noexcept;
    bool whole_counts() const noexcept;

    // Warns where a noise-free frame exceeds the full well or the bit depth, or where read noise may be clipped at 0
    // DN. `about` is put in front of numbers of pixels ("about " for a rough image).
    void warn(const Buffer<double> &electrons, const char *about, const std::string &source, const Log &log) const;

  private:
    void scale(Quantity quantity, double *image) const noexcept;

    size_t pixels_;
    Readout readout_;
    bool photon_noise_;
    bool electrons_;          // without gain and bias: otherwise photons
    Buffer<double> response_; // electrons per photon; empty if all are 1
    double dark_e_, read_e_;
    double full_well_e_; // of all coadds together; infinite if the scene names none
    double e_per_count_, bias_;
    double largest_count_; // 0 = counts are not rounded
};

} // namespace toliman::optics
