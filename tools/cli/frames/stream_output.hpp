// Writes the frames of a stream as the mission's image service does: pairs, batches or FITS files.
#pragma once
#include "common/common.hpp"
#include "common/interface.hpp"
#include "frames/stream.hpp"

namespace cli {

// What all frames of a stream have in common.
struct StreamLayout {
    OutputFolder &folder;
    std::string session, roi; // name of the first session, those of others are NAME-2, NAME-3 ...
    size_t rows, cols;
    double exposure_s;
    int bit_depth; // at most 16
    size_t pixels() const noexcept { return rows * cols; }
    std::string session_of(const Exposure &exposure) const;
};

// Takes the frames that are not dropped, in order. Each session has files of its own.
class StreamOutput : public Interface {
  public:
    explicit StreamOutput(const StreamLayout &layout) : layout_(layout) {}
    void write(const Exposure &exposure, const uint16_t *counts);
    virtual void commit() {}

  protected:
    const StreamLayout layout_;
    std::string session_; // of the frames

  private:
    virtual void begin_session() {}
    virtual void add(const Exposure &exposure, const uint16_t *counts) = 0;
};

// SESSION_frames.bin and SESSION_meta.jsonl of each session.
std::unique_ptr<StreamOutput> pair_stream(const StreamLayout &layout);
// SESSION_batch0000.nc ..., 50 frames each.
std::unique_ptr<StreamOutput> batch_stream(const StreamLayout &layout);
// frame_proc_CAMTIME.fits.gz of each frame.
std::unique_ptr<StreamOutput> fits_stream(const StreamLayout &layout);

// The true values, a line of CSV per exposure: NAME_truth.csv, which exists when all frames do.
class TruthTable {
  public:
    explicit TruthTable(const StreamLayout &layout);
    void write(const Exposure &exposure, double separation_px, size_t hits);
    void need_space(const std::vector<size_t> &axes, size_t width) const { file_.need_space(axes, width); }
    void commit() { file_.commit(); }

  private:
    const StreamLayout &layout_;
    OutputFile file_;
};

} // namespace cli
