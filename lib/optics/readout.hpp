// What happens to the charge of a pixel until it is counted: exchange with its neighbours, and readout. Both ways.
#pragma once
#include <limits>

#include "base/buffer.hpp"
#include "scene/parameter.hpp"
#include "scene/scene.hpp"

namespace toliman::optics {

// Images are [rows][cols] of electrons, or of their derivatives. A detector without such effects costs nothing.
class Readout {
  public:
    explicit Readout(const Scene &scene);

    // The readout of the sum of this many frames, which are taken to be alike.
    Readout of_frames(double frames) const;

    bool any() const noexcept { return mixes() || bends(); }
    bool is_linear() const noexcept { return exchange_ == 0 && curve_ == 0; }
    bool mixes() const noexcept { return exchange_ != 0 || couple_ != 0; } // pixels with their neighbours
    uint64_t digest(uint64_t hash) const noexcept;

    // Adds to the light that each pixel collects what it receives while its column is shifted.
    void add_smear(double *light) const;
    bool smears() const noexcept { return smear_ != 0; }
    double smear() const noexcept { return smear_; }

    // The steps from charge, mean or drawn, to electrons read, in their order. Read noise comes after them.
    void exchange(double *charge) const;
    void couple(double *charge) const { couple(rows_, cols_, charge); }
    void bend(double *charge) const noexcept;
    void read(double *charge) const; // all three

    // The inverse, for counts, which become those of an ideal detector. Those that saturate, from `limit` electrons of
    // charge on, stay at it, with their neighbours if pixels are mixed. Counts that are not finite stay as they are,
    // and so do all others then.
    void undo_counts(double e_per_count, double bias, double limit, double *counts) const;

    // Derivatives of read() at these charges, and their inverse and adjoint.
    void differentiate(const double *charge, double *image) const;
    void undo_derivative(const double *charge, double *image) const;
    void adjoint(const double *charge, double *weights) const;
    // Variances of charges become those of what is read. The covariance of neighbours is left out.
    void read_variance(const double *charge, double *variance) const;

    double bent(double charge) const noexcept { return charge - curve() * charge * charge; }
    double straight(double electrons) const noexcept; // inverse of bent()
    // Variance of read noise in charges that undo() returns, over that of the noise.
    double noise_gain() const noexcept;

    // Whether a parameter belongs to the detector, and the change of charges (before exchange) that changes what is
    // read as a unit of the parameter does.
    static bool has(Parameter::Kind kind) noexcept;
    Buffer<double> derivative(Parameter::Kind kind, const Buffer<double> &charge, double dark_e) const;

    // Brightest charge that read() can be inverted for; infinite without a limit.
    double most_charge() const noexcept;
    // The charge from which on more charge is read as less; infinite without non-linearity.
    double brightest_reading() const noexcept {
        return curve_ > 0 ? 0.5 / curve() : std::numeric_limits<double>::infinity();
    }
    // Couples the pixels of an image of another size.
    void couple(size_t rows, size_t cols, double *charge) const;

  private:
    bool bends() const noexcept { return curve_ != 0; }
    double exchange_factor() const noexcept { return exchange_ / frames_; }
    double curve() const noexcept { return curve_ / frames_; }
    void undo_bend(double *electrons) const noexcept;
    void undo_coupling(double *electrons) const;
    void undo_exchange(double *electrons) const;
    template <class Step> void invert(double *image, const Step &step) const;

    size_t rows_, cols_;
    double smear_, exchange_, couple_, curve_; // exchange: px^2 per e, curve: per e, of one exposure
    double frames_;                            // exposures in a frame
};

} // namespace toliman::optics
