// Values of frames as lines of CSV, for `encode`.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frames/estimator.hpp"
#include "frames/frames_in.hpp"

namespace cli {

// Why a value may be wrong.
struct Doubt {
    const char *kind; // of all frames with this doubt: "did not converge"
    std::string text; // of one frame
};

// What a fit measured in a frame.
struct Separation {
    double time_days, px; // px is NaN if the fit did not converge
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

// The estimator must outlive the encoder. cadence: seconds from frame to frame, for fits; otherwise the time of a frame
// is that in the table FRAMES of its file, or else that of the frame of this number in the scene.
std::unique_ptr<Encoder> make_encoder(const Estimator &estimator, size_t most, const std::optional<double> &cadence);

} // namespace cli
