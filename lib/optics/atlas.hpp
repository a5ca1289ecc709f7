// The atlas: one image of each star, sampled around the star, and its derivatives by parameters of the optics. They are
// interpolated at the pixels of a frame for any places of the stars, so that one propagation serves all frames.
#pragma once
#include <array>
#include <complex>
#include <functional>
#include <vector>

#include "base/buffer.hpp"
#include "kernels/shift.hpp"
#include "optics/imager.hpp"

namespace toliman::optics {

// Images of one star, [rows][cols] of plan.atlas each, in expected photons per pixel: the image itself first.
using Planes = std::vector<Buffer<double>>;

// The plan of images on the samples of an atlas, for a star at most `reach` px [x, y] from the centre of the frame.
Plan plan_around(const Plan &plan, const std::array<double, 2> &reach);

class Atlas {
  public:
    // Makes the planes of a star on the grid of `plan`, with the star at its centre.
    using Draw = std::function<Planes(const Plan &plan, const Imager &imager, const Light &light, size_t star)>;

    // Samples for stars at most `reach` px [star][x, y] from the centre of the frame. The arguments are not needed
    // afterwards.
    Atlas(const Scene &scene, const Pupil &pupil, const Plan &plan, const Light &light, const Offsets &reach,
          const Draw &draw);

    // The atlas of images with this spectrum: that of this atlas times transfer(f_x, f_y), cycles per px, and a factor.
    // Images are taken as periodic, which is wrong within the reach of the blur from the edges of the atlas.
    using Transfer = std::function<std::complex<double>(double fx, double fy)>;
    Atlas filtered(const Transfer &transfer, double factor) const;
    Atlas scaled(double factor) const;

    // Where the pixels of a frame are among the samples of a star: the first sample of the first pixel, and the weights
    // of the samples.
    struct Place {
        size_t row, col;
        double y[kernels::kShiftOrders][kernels::kMostTaps], x[kernels::kShiftOrders][kernels::kMostTaps];
    };

    // Whether a star may be at [x, y] px from the centre of the frame.
    bool covers(size_t star, long double x, long double y) const noexcept;
    // For values (1 order), first (2) and second derivatives (3). The atlas must cover the place.
    Place place(size_t star, long double x, long double y, size_t orders) const noexcept;

    // Row r of an image and its derivatives by the star's place: value, x, y, xx, xy, yy, as many as the orders imply.
    // Each out has cols() elements; scratch has scratch_size() of them.
    void row(size_t star, size_t plane, const Place &place, size_t r, size_t orders, double *const *out,
             double *scratch) const noexcept;

    // The samples of a plane that the atlas does not keep, from an image of the star [rows][cols] on the grid of
    // plan_around(), as `draw` makes it.
    Buffer<double> samples_of(size_t star, const Buffer<double> &image) const;
    // Row r of that plane; values only.
    void row_of_samples(size_t star, const Buffer<double> &samples, const Place &place, size_t r, double *out,
                        double *scratch) const noexcept;

    // Adjoints of both: adds the weights [cols()] of row r to the samples that contribute to it; ...
    void spread(size_t star, const double *weights, const Place &place, size_t r, Buffer<double> &samples,
                double *scratch) const noexcept;
    // ... and returns the weights of the image from those of the samples.
    Buffer<double> image_weights(size_t star, const Buffer<double> &samples) const;

    size_t cols() const noexcept { return cols_; }
    size_t scratch_size() const noexcept { return kernels::kShiftOrders * oversampling_ * used(); }
    size_t planes(size_t star) const noexcept { return stars_[star].planes.size(); }
    const Buffer<double> &plane(size_t star, size_t number) const noexcept { return stars_[star].planes[number]; }

  private:
    struct Star {
        Planes planes; // each row in `oversampling` parts: samples 0, o, 2 o, ..., then 1, 1 + o, ...
        size_t rows, cols, part;
    };
    Buffer<double> samples_of(const Star &star, const Buffer<double> &image) const;
    Star sample(const Scene &scene, const Pupil &pupil, const Plan &plan, const Light &light, size_t star,
                const std::array<double, 2> &reach, const Draw &draw) const;
    size_t used() const noexcept;
    template <class Visit> void for_each_sample(const Star &star, Visit visit) const;
    void sum_along_y(const Star &star, const Buffer<double> &plane, const Place &place, size_t r, size_t orders,
                     double *const *lines) const noexcept;
    void offsets_along_x(const Place &place, size_t *offset) const noexcept;
    void offsets_along_y(const Star &star, const Place &place, size_t r, size_t part, size_t *offset) const noexcept;
    void sum_along_x(const double *line, const Place &place, size_t orders, double *const *out) const noexcept;

    size_t rows_, cols_, oversampling_;
    kernels::Window window_;
    std::vector<Star> stars_;
};

} // namespace toliman::optics
