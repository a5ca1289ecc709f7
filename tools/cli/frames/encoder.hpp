// Values of frames as lines of CSV, for `encode`, and their separations, reduced to the orbit of a binary (--system).
#pragma once
#include "frames/estimator.hpp"
#include "frames/frames_in.hpp"
#include "frames/predictions.hpp"
#include "scenes/observer_options.hpp"

namespace cli {

// Why a value may be wrong.
struct Doubt {
    const char *kind; // of all frames with this doubt: "did not converge"
    std::string text; // of one frame
};

// The columns of a goodness of fit, and its cells; Result has the members of toliman_frame_goodness.
inline constexpr char kGoodnessColumns[] = "chi_square,chi_square_sigma,largest_residual,goodness,bad_pixels";
std::string goodness_cells(const toliman_frame_goodness &fit);
template <class Result> toliman_frame_goodness goodness_of(const Result &result) {
    auto fit = toliman::sized<toliman_frame_goodness>();
    fit.goodness = result.goodness;
    fit.chi_square = result.chi_square;
    fit.chi_square_sigma = result.chi_square_sigma;
    fit.largest_residual = result.largest_residual;
    fit.bad_pixels = result.bad_pixels;
    return fit;
}
// Adds the doubt about a fit that is poor or too good.
void doubt_goodness(const toliman_frame_goodness &fit, std::vector<Doubt> &doubts);

// Throws Failure for frames that are sums; estimator: "a network".
void refuse_sums(FrameFile &frames, const char *estimator);

// What a fit measured in a frame.
struct Separation {
    std::optional<int64_t> tai_ns; // as Predictions
    double time_days, px;          // px is NaN if the fit did not converge
};

class Encoder {
  public:
    virtual ~Encoder() = default;
    Encoder(const Encoder &) = delete;
    Encoder &operator=(const Encoder &) = delete;
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

  protected:
    Encoder() = default;
};

// The estimator and `progress` must outlive the encoder. clock: for fits, as in Predictions.
std::unique_ptr<Encoder> make_encoder(const Estimator &estimator, size_t most, const FrameClock &clock,
                                      Progress &progress);

// estimator.fit must be there. Otherwise as make_encoder.
std::unique_ptr<Encoder> make_fit_encoder(const Estimator &estimator, size_t most, const FrameClock &clock,
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

// Adds the columns mjd, factor, geometric_arcsec and reduced_px to those of `encoder`, which must be that of a fit
// whose time 0 is known. The others are as without this. Throws Failure for bad options.
std::unique_ptr<Encoder> make_reducing_encoder(std::unique_ptr<Encoder> encoder, const FrameReductionOptions &options,
                                               const Estimator &estimator, Progress &progress);

} // namespace cli
