// Maximum-likelihood fit of the forward model to one frame: it follows the stars wherever orbit and pointing move them.
#pragma once
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "base/view.hpp"
#include "fit/model.hpp"
#include "fit/search.hpp"

namespace toliman::fit {

constexpr double kCapturePx = 15, kMostCapturePx = 64;

// What is known of a frame: toliman_fit_prediction.
struct Prediction {
    double days = 0, shift_px[2] = {0, 0};
    double separation_px = 0, position_angle_deg = 0; // 0 = those of the scene
    Spread spread;                                    // of a sum of frames
    std::optional<DetectorWindow> window;             // of the frame; none: that of the scene
    bool may_lack_observer = false;                   // where the observer has no state, the places are on the orbit
};

enum Flag : uint32_t { not_converged = 1, saturated = 4, edge = 8, searched = 16 };

// Parameters as the model takes them (fit/model.hpp), and their covariance, the inverse Fisher matrix.
struct State {
    double values[kMostParameters] = {}, covariance[kMostParameters * kMostParameters] = {}; // [n], [n][n]
};

// toliman_fit_result; values and covariance in the order of Fit::parameters().
struct Result {
    uint32_t flags = 0;
    double displacement_px = 0;
    FrameGoodness goodness; // without the bad pixels
    BadPixels bad;
    int iterations = 0;
    size_t excluded = 0;
    double values[kMostParameters] = {}, covariance[kMostParameters * kMostParameters] = {}; // [n], [n][n]
    State state;
};

// Working memory of one thread: Fit::work().
struct FitWork {
    Work model;
    Search search;
    Buffer<double> expected;  // counts [rows][cols]; also the excess of each pixel
    Buffer<double> ideal;     // counts [rows][cols] of an ideal detector, if that of the scene is not
    Buffer<double> repaired;  // counts [rows][cols] without spikes; allocated for the first frame that has some
    BadPixels known_bad = {}; // of the scene, at their places in this frame
};

// Const calls may run on several threads, each with its own work.
class Fit {
  public:
    // The simulator is not needed afterwards; workers compute the model images, whose progress is reported.
    // Status::argument for parameters that are always free or given twice, Status::scene if the scene's frame does not
    // determine all.
    Fit(const optics::Simulator &simulator, const std::vector<Parameter> &free, double capture_px, unsigned workers,
        const Progress &progress);

    // The fit between two of the same parameters: as Model. Predicted places are interpolated, too.
    Fit(const Fit &first, const Fit &next, double share);

    // The fit of sums of frames.
    Fit(const Fit &frame, const Spread &spread);

    FitWork work() const;
    // Fits counts of rows() x cols(). The result depends on the arguments only.
    void frame(ImageView<const double> counts, const Prediction &prediction, FitWork &work, Result &result) const;
    // The counts that an ideal detector would give, in work.ideal or the same; all functions but frame() take these.
    ImageView<const double> undo(ImageView<const double> counts, FitWork &work) const;
    void frame_of_ideal(ImageView<const double> counts, const Prediction &prediction, FitWork &work,
                        Result &result) const;
    // Whether the model images cover the predicted places.
    bool covers(const Prediction &prediction) const { return model_.covers(places_of(prediction).values); }
    // The expected counts, and the result of their fit: values and covariance.
    void expect(const Prediction &prediction, ImageView<double> counts, FitWork &work) const;
    void predict(const Prediction &prediction, FitWork &work, Result &result) const;

    // Where a fit starts: the model's parameters, and the predicted separation.
    struct Start {
        double values[kMostParameters] = {};
        double separation_px = 0;
    };
    // Status::argument if the model images do not cover the predicted places.
    Start start_of(const Prediction &prediction) const;
    // Moves values, those of the start, to where a search finds the stars; false if the model images do not cover it.
    bool search(ImageView<const double> counts, const Start &start, double *values, FitWork &work) const;
    // The bad pixels of counts near the values of their fit; none if a frame is poor without them.
    BadPixels bad_pixels_at(ImageView<const double> counts, const double *values, FitWork &work) const;
    // The result for the model's parameters `values` with this covariance [n][n]; without what depends on the counts.
    void describe(const double *values, const double *covariance, Result &result) const;

    const std::vector<Parameter> &parameters() const noexcept { return parameters_; }
    size_t rows() const noexcept { return scene_.detector.rows; }
    size_t cols() const noexcept { return scene_.detector.cols; }
    double capture_px() const noexcept { return capture_px_; }
    const Model &model() const noexcept { return model_; }
    const KnownBadPixels &known_bad() const noexcept { return known_bad_; }
    const Scene &scene() const noexcept { return scene_; }
    double last_days() const noexcept { return longest_days(scene_.cadence); } // of the scene's frames
    // Predicted place of B minus that of A, px, without a separation given.
    std::array<double, 2> difference(double days) const;
    std::array<double, 2> difference_at(const Prediction &prediction) const;
    std::array<double, 2> difference_on_orbit(double days) const; // without an observer
    double pixel_scale_arcsec() const noexcept { return scene_.detector.pixel_scale_arcsec; }
    double sigma_px() const noexcept { return sigma_px_; } // of the separation in the scene at time 0
    uint64_t digest() const noexcept { return digest_; }

  private:
    Start places_of(const Prediction &prediction) const;
    bool step(ImageView<const double> counts, double blend, double *values, FitWork &work, double &moved) const;
    bool converge(ImageView<const double> counts, double blend, double *values, FitWork &work, Result &result) const;
    bool leave_out_bad_pixels(ImageView<const double> counts, double *values, FitWork &work, Result &result) const;
    bool fit_elsewhere(ImageView<const double> counts, const Start &start, bool still, double *values, FitWork &work,
                       Result &result) const;
    void settle(ImageView<const double> counts, double *values, FitWork &work, Result &result) const;
    void report(const double *values, const Work &work, Result &result) const;
    uint64_t digest_of_all() const;

    Scene scene_;
    KnownBadPixels known_bad_;
    optics::Light light_;
    std::vector<Parameter> parameters_;
    Model model_;
    double capture_px_, share_a_; // share_a: of the separation, from the scene's centre to A
    double centre_[2];            // of the scene, px from the centre of the frame
    double sigma_px_ = 0;
    uint64_t digest_ = 0;
};

// That of a sum of frames; `frame` itself if there is only one.
std::shared_ptr<const Fit> of_sum(std::shared_ptr<const Fit> frame, const Spread &spread);

} // namespace toliman::fit
