// Frames of one input of `track`: a file (dated_files), or a pair of files that may still grow.
#pragma once
#include <chrono>

#include "common/common.hpp"
#include "common/interface.hpp"

namespace cli {

constexpr std::chrono::seconds kPatience(1); // of frames that are not in the state on the disk, at least

// "in/x_meta.jsonl:7": where a frame or message comes from.
std::string place_of(const toliman_ingest_event &event);

// Whether frames of so many bits come as this pixel type: u32le above 16 bits.
inline bool suits(int32_t pixel, uint32_t bit_depth) noexcept {
    return bit_depth == 0 || (pixel == TOLIMAN_PIXEL_U32) == (bit_depth > 16);
}

// Frame ids first ... end - 1; all ids if both are 0.
struct FrameIds {
    int64_t first = 0, end = 0;
    bool contains(int64_t id) const noexcept { return first == end || (id >= first && id < end); }
};

class FrameSource : public Interface {
  public:
    // Reads the next frame, damage or warning as toliman_ingest_next does; false if there is none (yet). Pixels and
    // texts stay valid during the next `buffers` - 1 calls. Failure with kExitInput if the input cannot be read.
    virtual bool next(toliman_frame &frame, toliman_ingest_event &event) = 0;
    virtual int64_t skipped() const = 0; // frames that nobody wants
    // Finds a frame that is not at its place in the file, from that of a FRAME event: reads it into `pixels`, and
    // returns how many bytes it is from there; 0 if it is not found elsewhere.
    virtual int64_t find(int64_t, const toliman_frame &, std::vector<uint8_t> &) const { return 0; }
    virtual void set_shift(int64_t) {} // of the frames that follow
};

// Of a message about an input. `damage` counts for --strict.
enum class Severity { note, warning, damage };

// What the frames of inputs are for: a tracker, or sums.
class FrameSink : public Interface {
  public:
    virtual const toliman_track_options &settings() const noexcept = 0; // of frames, times and clock
    virtual size_t batch() const noexcept = 0; // frames of a source that must stay valid at the same time
    // Takes what source->next() delivered, and keeps the source as long as the frame is needed.
    virtual void take(const std::shared_ptr<FrameSource> &source, const toliman_frame &frame,
                      const toliman_ingest_event &event) = 0;
    virtual void report(Severity severity, const std::string &warning, const std::string &input,
                        const std::string &text) = 0;
    virtual void count_skipped(int64_t frames) noexcept = 0;
    virtual void wait() = 0; // to be called while no frame arrives
};

// The mission's pair of files, by the name of either of them.
class PairSource : public FrameSource {
  public:
    // Frames of pixels that do not suit this bit depth are refused; 0: none.
    PairSource(const std::string &path, const toliman_ingest_options &options, uint32_t bit_depth = 0);
    bool next(toliman_frame &frame, toliman_ingest_event &event) override;
    int64_t skipped() const override;
    int64_t find(int64_t offset, const toliman_frame &reference, std::vector<uint8_t> &pixels) const override;
    void set_shift(int64_t bytes) override;
    int32_t pixel() const; // TOLIMAN_PIXEL_...; 0: not known yet
    void finish();         // the files do not grow any more: next() reports what is missing

  private:
    toliman::pair_reader reader_;
    uint32_t bit_depth_;
};

} // namespace cli
