// What the detector makes of the light that falls on it:
//     photons x qe x flat + dark -> Poisson -> full well -> + read noise -> / gain + bias -> whole numbers in bit_depth
// A stage that the scene does not name does not exist.
#pragma once
#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "optics/scene.hpp"

namespace toliman::optics {

enum class Quantity { frame, derivative, variance };
enum class Unit { photon, electron, dn };

class DetectorStages {
  public:
    explicit DetectorStages(const Scene &scene);

    // Expected photons to electrons, or their derivatives, without dark current.
    void collect(Buffer<double> &image) const noexcept;
    double dark_e() const noexcept { return dark_e_; } // a pixel and frame
    // Variance that is added to that of the electrons: read noise and rounding.
    double added_variance_e2() const noexcept;

    // Given     expected electrons, one value a pixel as all arrays; overwritten
    // Returned  image: what frame number `frame` of this seed holds
    void detect(uint64_t seed, uint64_t frame, double *expected, double *image) const noexcept;

    // An image of electrons in the frame's own unit, DN or electrons; in place or as a copy.
    void to_counts(Quantity quantity, double *image) const noexcept;
    Buffer<double> in_counts(Buffer<double> image, Quantity quantity) const noexcept;
    double counts_of(double electrons) const noexcept { return electrons / e_per_count_ + bias_; }
    Unit unit() const noexcept;
    bool whole_counts() const noexcept;

    // Tells the log where a frame without noise meets the full well or the bit depth; `about` stands before numbers of
    // pixels.
    void warn(const Buffer<double> &electrons, const char *about, const std::string &source, const Log &log) const;

  private:
    size_t pixels_;
    bool photon_noise_, has_qe_;
    Buffer<double> response_; // electrons a photon; empty where all are 1
    double dark_e_, read_e_;
    double capacity_e_; // infinite without a full well
    double e_per_count_, bias_;
    double largest_count_; // 0 = counts are not rounded
};

} // namespace toliman::optics
