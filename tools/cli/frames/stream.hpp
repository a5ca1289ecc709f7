// The stream of the camera (`simulate --rate`): when its frames are exposed, where the stars are, what is lost.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cli {

// 0: none of it.
struct StreamOptions {
    double rate_hz = 0, duration_s = 0;
    double jitter_px = 0, corner_hz = 10; // rms along x and along y, and corner frequency of its spectrum
    double drift_px = 0, drift_s = 5700;  // radius and period of a circle
    double hits = 0;                      // mean number of cosmic rays per frame
    double drops = 0, drop_run = 1;       // fraction of the frames, mean length of a run of them
    double restart_s = 0, session_s = 0;  // time from one restart of the camera, one session, to the next
};

// Uniform numbers of (seed, use, counter) alone.
class StreamNoise {
  public:
    enum class Use : uint64_t { jitter = 1, drops, hits };
    explicit StreamNoise(uint64_t seed) noexcept : seed_(seed) {}
    double uniform(Use use, uint64_t counter) const noexcept; // in (0, 1)

  private:
    uint64_t seed_;
};

struct Hit {
    size_t pixel;
    double electrons; // expected
};

struct Exposure {
    int64_t index = 0;                 // from 0 at the start of the stream
    double time_s = 0, host_s = 0;     // start of the exposure, and end of its readout by the host's clock
    int64_t session = 0, restarts = 0; // number of the session; of restarts of the camera within it
    int64_t frame_id = 0, stamp_ns = 0;
    bool is_dropped = false;
    int64_t dropped = 0; // frames dropped before this one, of one that is not
    double x_px = 0, y_px = 0;
};

class Stream {
  public:
    // time_zero_ns: the camera's clock at the start of the stream.
    Stream(const StreamOptions &options, uint64_t seed, int64_t time_zero_ns);
    int64_t count() const noexcept { return count_; } // of indices; pauses have no exposures
    // The exposure of the next index; false while the camera is closed.
    bool next(Exposure &exposure);
    // Pixels that cosmic rays hit, each once.
    std::vector<Hit> hits(int64_t index, size_t pixels) const;

  private:
    void move(Exposure &exposure);
    void drop(int64_t index);

    StreamOptions options_;
    StreamNoise noise_;
    int64_t time_zero_ns_, count_, pause_, restart_, session_; // the last four in frames
    double memory_, push_;                                     // of the jitter from frame to frame
    double jitter_[2] = {};
    int64_t next_ = 0, power_on_ = 0, power_ons_ = 0, last_id_ = -1;
    bool is_dropping_ = false;
};

} // namespace cli
