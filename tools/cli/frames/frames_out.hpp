// Writes frames: .npy, FITS, headerless counts, or the mission's pair of files.
#pragma once
#include "common/common.hpp"
#include "common/interface.hpp"
#include "scenes/scene.hpp"

namespace cli {

// Writes frames in order; the output appears after commit().
class FrameOutput : public Interface {
  public:
    virtual void write(const double *images, size_t count) = 0;
    virtual void commit() = 0;
};

// Simulated frames: all that outputs with a header need.
struct Simulated {
    const Scene &scene;
    FrameRange range;
    uint64_t seed;
    size_t count() const noexcept { return static_cast<size_t>(range.end - range.first); }
    size_t rows() const noexcept { return static_cast<size_t>(scene.info.rows); }
    size_t cols() const noexcept { return static_cast<size_t>(scene.info.cols); }
};

// Time in ns of a frame `days` after time 0 of a scene, which is TAI time_zero_ns with an observer, otherwise 0.
// Nothing beyond 100,000 days or 64 bits.
std::optional<int64_t> frame_time(double days, int64_t time_zero_ns);

// Format of headerless counts; a count above 2^bit_depth - 1 is an error and is never wrapped.
struct CountFormat {
    bool wide; // u32le, otherwise u16le
    int bit_depth;
    const char *dtype() const noexcept { return wide ? "u32le" : "u16le"; }
};

// Float64 with the given axes, columns last: FITS or .npy by the suffix. A FITS header describes the scene, if given.
std::unique_ptr<FrameOutput> image_output(const std::string &path, const std::vector<size_t> &axes,
                                          const Scene *scene = nullptr);
std::unique_ptr<FrameOutput> fits_output(const std::string &path, const std::vector<size_t> &axes, const Scene *scene);

std::unique_ptr<FrameOutput> count_output(const std::string &path, const CountFormat &format, const Simulated &frames);
// Cube with a full header and a table of times.
std::unique_ptr<FrameOutput> cube_output(const std::string &path, const Simulated &frames);
// <session>_frames.bin and <session>_meta.jsonl in a folder, see formats.md.
std::unique_ptr<FrameOutput> session_output(const std::string &folder, const std::string &session,
                                            const CountFormat &format, const Simulated &frames);

// The path, of a file that does not exist: those of a downlink may be the only copy.
std::string free_path(const std::string &path);

constexpr char kOnlyRegion[] = "single_roi"; // the mission's name of it

// The members of a line of a side file that each line must have, and the pixel type.
struct SideLine {
    int64_t frame_id, stamp_ns;
    double host_s;
    int64_t dropped;
};
std::string side_members(const SideLine &line, const std::string &roi, size_t rows, size_t cols,
                         const std::string &session, const char *dtype);

} // namespace cli
