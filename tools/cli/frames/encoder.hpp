// Values of frames as lines of CSV, for `encode`, and their separations, reduced to the orbit of a binary (--system).
#pragma once
#include "common/interface.hpp"
#include "frames/estimator.hpp"
#include "frames/frames_in.hpp"
#include "frames/predictions.hpp"
#include "scenes/exposures.hpp"
#include "scenes/observer_options.hpp"

namespace cli {

// Why a value may be wrong.
struct Doubt {
    const char *kind; // of all frames with this doubt: "did not converge"
    std::string text; // of one frame
};

// What a fit measured in a frame.
struct Separation {
    std::optional<int64_t> tai_ns; // as Predictions
    double time_days, px;          // px is NaN if the fit did not converge
};

class Encoder : public Interface {
  public:
    virtual const char *columns() const = 0; // after file and frame
    // The file of the frames that follow.
    virtual void open(FrameFile &) {}
    // Estimates frames first ... first + count - 1 of the file, at most `most` of the constructor, on all processors.
    virtual toliman_status encode(const toliman_image &image, size_t first, size_t count) = 0;
    // Of frame i of the last call: its numbers, and doubts about them.
    virtual std::string line(size_t i) const = 0;
    virtual std::vector<Doubt> doubts(size_t i) const = 0;
    // Of frame i of the last call; of fits only.
    virtual Separation separation(size_t) const { return {}; }
    // Messages about all frames, after the last one.
    virtual void end(Progress &) const {}
};

// The estimator and `progress` must outlive the encoder. clock: for fits, as in Predictions.
std::unique_ptr<Encoder> make_encoder(const Estimator &estimator, size_t most, const FrameClock &clock,
                                      Progress &progress);

// The reduction of the separations of encoded frames to the orbit of a binary.
struct FrameReductionOptions {
    void add_to(CLI::App &command);
    // Takes what is not given from the scene of a fit: time 0, observer, and the system of an observer that is known.
    // What differs from the scene is reported. Throws Failure for options that need a system.
    void use_scene(const Estimator &estimator, Notes &notes);

    std::optional<std::string> system, epoch; // no reduction without a system
    ObserverOptions observer;
    std::optional<double> plate_scale;   // arcsec per px; otherwise that of the scene
    std::optional<int64_t> time_zero_ns; // TAI of time 0 of the scene, after use_scene
};

// Reduces the separations of an encoder, which must be that of a fit whose time 0 is known.
class FrameReduction {
  public:
    static constexpr char kColumns[] = ",mjd,factor,geometric_arcsec,reduced_px"; // after those of the encoder
    // Throws Failure for bad options. They must outlive this object.
    FrameReduction(const FrameReductionOptions &options, const Estimator &estimator, Progress &progress);
    // The frames of the last call of the encoder. Those without time on target are not reduced.
    void reduce(const Encoder &encoder, size_t count);
    std::string line(size_t i) const; // of frame i of them
    // Messages about all frames, after the last one.
    void end(Progress &progress) const;

  private:
    struct Row { // NaN for a frame that is not reduced
        double factor, geometric_arcsec, reduced_px;
    };
    int64_t time_of(const Separation &measured) const;
    Row row_of(double px, const toliman_sky_prediction &seen);

    const FrameReductionOptions &options_;
    std::string scene_;
    double plate_scale_; // arcsec per px
    toliman::sky_predictor sky_;
    double exposure_s_;
    SceneExposures exposures_;
    std::vector<int64_t> times_;                  // TAI, of the last call
    std::vector<Row> rows_;                       // of the last call
    size_t frames_ = 0, unreduced_ = 0, far_ = 0; // far_: separations far from those of the system
};

} // namespace cli
