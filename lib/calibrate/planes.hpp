// Derivatives of a frame by the parameters of the instrument, row by row from an atlas of its own.
#pragma once
#include <memory>
#include <vector>

#include "base/progress.hpp"
#include "fit/spread.hpp"
#include "optics/atlas.hpp"
#include "optics/detector.hpp"
#include "optics/simulator.hpp"

namespace toliman::calibrate {

// Const calls may run on several threads.
class Planes {
  public:
    // Of the instrument of `outline`, for stars up to `capture_px` from their places over the cadence. The outline is
    // not needed afterwards. spread: of the frames that are sums. key: what tells these planes from others. progress:
    // called during the construction only.
    Planes(const optics::Outline &outline, const std::vector<Parameter> &parameters, double capture_px,
           const Spread &spread = {}, uint64_t key = 0, const Progress &progress = {});

    uint64_t key() const noexcept { return key_; }
    size_t parameters() const noexcept { return entries_.size(); }
    // The image of each star itself is plane 0.
    const optics::Atlas &atlas() const noexcept { return *atlas_; }
    // What the images are made with (optics::plan_around()).
    const optics::Plan &plan() const noexcept { return plan_; }
    const std::array<double, 2> &reach() const noexcept { return reach_; } // of both stars, px [x, y]

    size_t scratch_size() const noexcept { return atlas_->scratch_size() + kPlaceLines * atlas_->cols(); }

    struct Places {
        optics::Atlas::Place star[2];
        std::vector<Buffer<double>> readout; // derivatives [rows][cols] by the parameters of the detector's readout
    };
    // Whether the stars may be at these values of the model (fit/model.hpp), and where their pixels are.
    bool covers(const double *values) const noexcept;
    void place(const double *values, Places &places, double *scratch) const;
    // Row r of the derivatives of the photons of both stars: lines [parameters()][cols].
    void row(const double *values, const Places &places, size_t r, double *const *lines,
             double *scratch) const noexcept;

  private:
    static constexpr size_t kPlaceLines = 6; // of Atlas::row() with all orders

    // A plane of each star, 0 = none; or second derivatives by its place.
    struct Entry {
        Parameter parameter;
        size_t plane[2];
        size_t place[2]; // 3 to 5: xx, xy, yy of Atlas::row(); 0 = none
        double factor;   // of these
    };
    std::vector<optics::Planes> draw(const optics::Outline &outline, const optics::Plan &plan,
                                     const optics::Imager &imager, const optics::Light &light,
                                     const Progress &progress);
    Buffer<double> charge(const double *values, const Places &places, double *scratch) const;
    void take(size_t entry, size_t star, Buffer<double> &image, optics::Planes &planes);

    const uint64_t key_;
    std::vector<Entry> entries_;
    optics::Plan plan_;
    std::array<double, 2> reach_;
    size_t orders_ = 1;                                      // of the atlas' rows of the image
    std::unique_ptr<const optics::DetectorStages> detector_; // if parameters of its readout are among the entries
    Buffer<double> response_;                                // of this detector, electrons per photon
    std::unique_ptr<optics::Atlas> atlas_;
};

} // namespace toliman::calibrate
