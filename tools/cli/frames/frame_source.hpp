// Frames of one input, for whoever estimates them: a file, or a pair of files that may still grow.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

#include "frames/frames_in.hpp"

namespace cli {

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
};

// Frames of a file. event.line is the index of the frame in the file, from 0.
class FileSource : public FrameSource {
  public:
    // Names frame k of the file, and sets its time; false if it is not wanted.
    using Label = std::function<bool(size_t k, toliman_frame &frame)>;
    FileSource(std::unique_ptr<FrameFile> file, size_t buffers, Label label);
    bool next(toliman_frame &frame, toliman_ingest_event &event) override;
    int64_t skipped() const override { return skipped_; }

  private:
    std::unique_ptr<FrameFile> file_;
    Label label_;
    std::vector<std::vector<double>> buffers_; // of doubles, which are aligned for every type
    size_t next_ = 0, frame_ = 0;              // buffer and frame that come next
    int64_t skipped_ = 0;
};

// The mission's pair of files, by the name of either of them.
class PairSource : public FrameSource {
  public:
    PairSource(const std::string &path, const toliman_ingest_options &options);
    bool next(toliman_frame &frame, toliman_ingest_event &event) override;
    int64_t skipped() const override;
    void finish(); // the files do not grow any more: next() reports what is missing

  private:
    toliman::pair_reader reader_;
};

// "in/x_meta.jsonl:7": where a frame or message comes from.
std::string place_of(const char *file, int32_t event, int64_t line);

} // namespace cli
