// Inputs of `toliman track` and `coadd`: files, folders, names on standard input, once or as they grow.
#pragma once
#include <set>

#include "downlink/frame_source.hpp"
#include "frames/predictions.hpp"

namespace cli {

// .npy and FITS files as sources of frames with session, frame id and time.
struct DatedFileOptions {
    std::optional<double> cadence; // seconds
    std::string session;           // empty: the name of the file
    std::string unit;              // of FITS files: name or number of the HDU; empty: see open_frames
    LeapSeconds leap_seconds;
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

struct InputOptions {
    void add_to(CLI::App &command);
    std::vector<std::string> inputs;
    std::string dtype;         // of pairs; empty: found in their files
    bool suits_folder = false; // pairs of other pixels than the bit depth of the folder's frames are refused
    bool needs_dtype = false;  // of pairs that are named on standard input
    std::string roi;           // frames of other regions are skipped; empty: the region of the folder
    DatedFileOptions dated;
    FrameIds frames; // all others are skipped
    bool follow = false;
};

// Throws Failure for inputs that are certainly a mistake.
void check_inputs(const InputOptions &options);

// TOLIMAN_PIXEL_... of the first pair with a valid line; 0: none.
int32_t first_pixel(const InputOptions &options);

// Sums of `coadd` among the inputs of a new state folder, which needs to know their noise.
struct KnownSums {
    // Reads the side files of pairs, and folders of them, as far as their frames are sums.
    explicit KnownSums(const std::vector<std::string> &inputs);
    bool waits = true;                     // there are pairs at most, and none has a line yet
    std::optional<toliman_spread> largest; // of the sum of the most frames; nothing for single frames
};

class Downlink {
  public:
    Downlink(const InputOptions &options, FrameSink &sink)
        : options_(options), sink_(sink), dated_(options.dated, sink) {}
    // Gives all frames to the sink; with `follow` until a signal.
    void read();

  private:
    // A pair that is followed.
    struct Growing {
        std::shared_ptr<PairSource> source;
        bool at_end = false, unreadable = false; // the last check read all there is; was reported
        int halves = 0;                          // checks that found one of the two files only
    };
    // A batch or FITS file that is followed, as it was at the last check.
    struct Whole {
        int64_t size = -1, seconds = 0, ns = 0; // bytes, time of the last change
        bool is_read = false;
    };
    void read_names();
    void read_input(const std::string &name);
    void read_folder(const std::string &folder);
    void read_pair(const std::string &path);
    std::shared_ptr<PairSource> open_pair(const std::string &path) const;
    void drain(const std::shared_ptr<FrameSource> &source);
    void read_growing(const std::string &side);
    void read_whole(const std::string &file);
    std::vector<std::string> files_in(const std::string &input);
    void follow();
    void conclude();

    const InputOptions &options_;
    FrameSink &sink_;
    DatedFiles dated_;
    std::map<std::string, Growing> growing_; // by their side files
    std::map<std::string, Whole> whole_;     // by name
    std::set<std::string> gone_;             // inputs that are followed and cannot be opened
    bool stopped_ = false;                   // by a signal
};

} // namespace cli
