// Values of frames as lines of CSV, for `encode`.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frames/estimator.hpp"
#include "frames/frames_in.hpp"
#include "frames/predictions.hpp"

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

} // namespace cli
