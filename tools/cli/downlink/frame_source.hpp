// Frames of one input of `track`: a file (dated_files), or a pair of files that may still grow.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

namespace cli {

// Frame ids first ... end - 1; all ids if both are 0.
struct FrameIds {
    int64_t first = 0, end = 0;
    bool contains(int64_t id) const noexcept { return first == end || (id >= first && id < end); }
};

class FrameSource {
  public:
    FrameSource() = default;
    virtual ~FrameSource() = default;
    FrameSource(const FrameSource &) = delete;
    FrameSource &operator=(const FrameSource &) = delete;
    // Reads the next frame, damage or warning as toliman_ingest_next does; false if there is none (yet). Pixels and
    // texts stay valid during the next `buffers` - 1 calls. Failure with kExitInput if the input cannot be read.
    virtual bool next(toliman_frame &frame, toliman_ingest_event &event) = 0;
    virtual int64_t skipped() const = 0; // frames that nobody wants
    // Finds a frame that is not at its place in the file, from that of a FRAME event: reads it into `pixels`, and
    // returns how many bytes it is from there; 0 if it is not found elsewhere.
    virtual int64_t find(int64_t, const toliman_frame &, std::vector<uint8_t> &) const { return 0; }
    virtual void set_shift(int64_t) {} // of the frames that follow
};

// The mission's pair of files, by the name of either of them.
class PairSource : public FrameSource {
  public:
    PairSource(const std::string &path, const toliman_ingest_options &options);
    bool next(toliman_frame &frame, toliman_ingest_event &event) override;
    int64_t skipped() const override;
    int64_t find(int64_t offset, const toliman_frame &reference, std::vector<uint8_t> &pixels) const override;
    void set_shift(int64_t bytes) override;
    void finish(); // the files do not grow any more: next() reports what is missing

  private:
    toliman::pair_reader reader_;
};

} // namespace cli
