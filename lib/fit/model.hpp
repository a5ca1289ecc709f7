// The forward model of one frame and its derivatives, row by row from the atlas.
#pragma once
#include <memory>
#include <vector>

#include "base/buffer.hpp"
#include "base/progress.hpp"
#include "base/view.hpp"
#include "fit/spread.hpp"
#include "frame/bad_pixels.hpp"
#include "kernels/normal.hpp"
#include "optics/atlas.hpp"
#include "optics/simulator.hpp"

namespace toliman::fit {

constexpr size_t kMostParameters = 32;

// The parameters as the model takes them: places of A and B (px from the centre of the frame), relative changes of both
// fluxes, background (photons per pixel), then those that the caller frees.
enum Index : size_t { x_a, y_a, x_b, y_b, flux_a, flux_b, background, always };

// Where the pixels of a frame are among the samples of both stars, in the atlas of a model and in that of the next one.
struct Places {
    optics::Atlas::Place first[2], next[2];
};

// Working memory of one thread.
struct Work {
    Places places = {}, predicted = {};
    Buffer<double> lines, scratch;                         // rows of images; of the atlas
    std::vector<const double *> columns;                   // lines of the derivatives, then the residual
    Buffer<double> sums, matrix;                           // Fisher matrix [n][n]
    double gradient[kMostParameters] = {}, chi_square = 0; // of the sum of squares over variances
    double inverse_counts = 0;      // sum of response^2/variance: with 2 per pixel, about the variance of chi_square
    size_t used = 0, saturated = 0; // pixels
    double largest = 0, excess = 0; // of linearise(): the largest squared residual over its variance, and excess_of()
    std::vector<double> smear, collected; // of Model::set_smear() and collected(); empty without smear
    BadPixels bad;                        // left out as if they had no response, until the caller changes them
};

// Const calls may run on several threads, each with its own work.
class Model {
  public:
    // Stars are up to `capture_px` from their places in the scene over its cadence. The simulator is not needed
    // afterwards. Status::unsupported for parameters that the scene lacks, Status::scene for those that do not change a
    // frame in first order.
    // With Effects::any, the latter are accepted: their derivatives are 0.
    enum class Effects { first_order, any };
    Model(const optics::Simulator &simulator, const std::vector<Parameter> &free, double capture_px, unsigned workers,
          const Progress &progress, Effects effects = Effects::first_order);

    // The model between two of the same parameters and detector: images are (1 - share) those of `first` plus share
    // those of `next`, 0 <= share <= 1. For a parameter of the optics that changes by d from one to the other, its
    // error is at most 1/8 d^2 times the second derivative of the image.
    Model(const Model &first, const Model &next, double share);

    // The model of a sum of frames: light, background and noise are those of all its frames, the stars' places their
    // mean.
    Model(const Model &frame, const Spread &spread);

    size_t parameters() const noexcept { return always + extras_.size(); }
    const optics::Atlas &atlas() const noexcept { return *atlas_; }
    Work work() const;

    // Whether the atlas covers the places.
    bool covers(const double *values) const noexcept;

    // Normal equations of the counts at these values: matrix, gradient, chi_square and numbers of pixels. blend: weight
    // of the counts in the variances, 0 = those of the model. Without counts, those of the expected ones.
    // Status::argument for a count that is not finite.
    void linearise(const ImageView<const double> *counts, const double *values, double blend, Work &work) const;

    // Adds the bad pixels of the counts at these values to work.bad, as far as they are found at once.
    BadPixels::Found find_bad_pixels(const ImageView<const double> &counts, const double *values, double *excess,
                                     Work &work) const;

    // A row of a frame: pixel by pixel the weights R^2/V and residuals (electrons - expected)/R of the counts, and the
    // derivatives of the photons by each parameter, those by places per unit flux (multiply by scale_of()).
    struct Row {
        size_t row;
        const double *weight, *residual, *light, *const *derivatives;
    };
    // Calls on_row for each row; the other arguments as in linearise(). Counts pixels in `work`, but sums nothing.
    template <class OnRow>
    void visit(const ImageView<const double> *counts, const double *values, double blend, Work &work,
               const OnRow &on_row) const {
        begin(counts, values, work);
        for (size_t r = 0; r < rows_; r++)
            on_row(row(counts, values, blend, r, work));
    }
    // Places move a star with its flux: the factor of the derivative by parameter i.
    static double scale_of(size_t i, const double *values) noexcept {
        return i < flux_a ? 1 + values[flux_a + i / 2] : 1;
    }

    // Weights R^2/V [cols] of the counts of row r that are expected for this light; scratch has 2 cols elements.
    void weigh(size_t r, const double *light, double *weight, double *scratch) const noexcept;

    // Expected counts [rows][cols].
    void expect(const double *values, ImageView<double> counts, Work &work) const;

    // Whitened images [rows][cols]: over the standard deviations of the expected counts at `values`, 0 where a pixel
    // saturates. The derivatives J_i of the counts are taken at `values`, too.
    // The sum over i of coefficients[i] J_i.
    void whiten_derivative(const double *values, const double *coefficients, double *image, Work &work) const;
    // Counts (NULL: those expected at `values`) minus those expected at `predicted`, which may be `values`; and
    // filtered [parameters() + 1], the inner products of whitened J_i and filter [rows][cols], the last one of filter
    // and filter.
    void whiten_residual(const ImageView<const double> *counts, const double *predicted, const double *values,
                         const double *filter, double *image, double *filtered, Work &work) const;

    // Whether frames are to be changed by undo() before they are given to the other functions: counts of an ideal
    // detector. Expected counts are those of an ideal detector, too, until read() changes them.
    bool has_readout() const noexcept { return readout_.any(); }
    void undo(double *counts) const { readout_.undo_counts(how_.e_per_count, how_.bias, how_.limit, counts); }
    void read(double *counts) const;
    const optics::Readout &readout() const noexcept { return readout_; }

    double bias() const noexcept { return how_.bias; }
    const kernels::CountModel &counts() const noexcept { return how_; }
    const Buffer<double> &usable() const noexcept { return usable_; } // electrons per photon, 0 for bad pixels
    uint64_t digest() const noexcept;

  private:
    // A parameter that the caller frees: a plane of the atlas, or a second derivative by the star's place.
    struct Extra {
        Parameter parameter;
        size_t plane[2], curve[2]; // of the first and second derivative of each star, 0 = none
        size_t place;              // 3 to 5: xx, xy, yy of Atlas::row(); 0 = none
        double factor;             // of that
    };

    std::vector<optics::Planes> draw(const optics::Simulator &simulator, const optics::Plan &plan,
                                     const optics::Imager &imager, const optics::Light &light,
                                     const Progress &progress);
    std::vector<optics::StarImages> images(const optics::Simulator &simulator, const optics::Plan &plan,
                                           const optics::Imager &imager, const optics::Light &light,
                                           const Progress &progress) const;
    size_t line_of(size_t star, size_t plane) const noexcept;
    size_t image(size_t star) const noexcept;
    size_t shared(size_t line) const noexcept;
    size_t spare() const noexcept; // first line for the rows of `next`
    void check_planes(const Scene &scene) const;
    void prepare(const double *values, size_t orders, Places &places) const noexcept;
    void begin(const ImageView<const double> *counts, const double *values, Work &work) const;
    void set_smear(const ImageView<const double> *counts, const double *values, Work &work) const;
    Row row(const ImageView<const double> *counts, const double *values, double blend, size_t r, Work &work) const;
    void read_row(size_t star, size_t plane, const Places &places, size_t r, size_t orders, double *const *out,
                  Work &work) const noexcept;
    void compute_row(const double *values, const Places &places, size_t orders, size_t r, Work &work) const noexcept;
    void weigh_row(const ImageView<const double> *counts, size_t r, double blend, Work &work) const;
    void leave_out(size_t r, double *weight, double *residual, Work &work) const noexcept;
    const double *collected(size_t r, Work &work) const noexcept;
    void counts_of_row(size_t r, const double *photons, double *counts) const noexcept;
    [[noreturn]] void refuse(const double *counts, size_t r) const;

    size_t rows_, cols_, pitch_; // of a line: columns, rounded up
    Buffer<double> response_;    // electrons per photon
    Buffer<double> usable_;   // the same, 0 for the scene's bad pixels, and for those that these or the border mix with
    std::vector<size_t> bad_; // pixels of the scene
    optics::Readout readout_;
    double tail_; // kBadPixelTail over the least response: excess_of() of electrons from photons
    kernels::CountModel how_;
    std::vector<Extra> extras_;
    size_t orders_ = 2;                                 // of the atlas' rows
    std::shared_ptr<const optics::Atlas> atlas_, next_; // next: of a model between two, otherwise none
    double share_ = 0;                                  // of next
};

} // namespace toliman::fit
