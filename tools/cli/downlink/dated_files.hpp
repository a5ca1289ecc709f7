// .npy and FITS files as sources of frames with session, frame id and time.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "downlink/frame_source.hpp"
#include "frames/frame_times.hpp"

namespace cli {

struct DatedFileOptions {
    std::optional<double> cadence; // seconds
    std::string session;           // empty: the name of the file
    std::string unit;              // of FITS files: name or number of the HDU; empty: see open_frames
    LeapSeconds leap_seconds;
    bool one_session = false;     // frames of all files are of one, for sums, which know them by their files
    bool begins_at_epoch = false; // times by the cadence or the table FRAMES count from time 0 of the folder
};

// Opens such files. Compares each file with those before it.
class DatedFiles {
  public:
    DatedFiles(const DatedFileOptions &options, FrameSink &sink) : options_(options), sink_(sink) {}
    // Frames outside `wanted` are skipped.
    std::shared_ptr<FrameSource> open(const std::string &path, const FrameIds &wanted);

  private:
    // The frames of a file. Times are set if they follow from the cadence.
    struct Span {
        std::string path, session;
        int64_t first_id, last_id, first_ns = 0, last_ns = 0;
    };
    Span span_of(FrameFile &file);
    FrameTimes times_of(FrameFile &file, const Span &span);
    void warn_of_overlap(Span span, const FrameTimes &times);

    const DatedFileOptions &options_;
    FrameSink &sink_;
    std::string unnumbered_;  // the file without FRAME1 that had --session
    std::vector<Span> spans_; // with times by the cadence
};

} // namespace cli
