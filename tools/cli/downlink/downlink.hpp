// Inputs of `toliman track`: files, folders, names on standard input, once or as they grow.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "downlink/arrival.hpp"
#include "downlink/frame_times.hpp"
#include "downlink/pair.hpp"

namespace cli {

struct DownlinkOptions {
    std::vector<std::string> inputs;
    std::string dtype;             // of pairs
    std::optional<double> cadence; // seconds, of .npy and FITS
    std::string session;           // of .npy and FITS; empty: their names
    LeapSeconds leap_seconds;
    bool clock = false; // the folder's clock changes the camera's time
    bool follow = false;
    size_t rows = 0, cols = 0; // of the tracker's frames
};

// Fails for inputs that cannot be meant.
void check_inputs(const DownlinkOptions &options);

class Downlink {
  public:
    Downlink(const DownlinkOptions &options, Receiver &receiver) : options_(options), receiver_(receiver) {}
    // Gives everything there is; with `follow` until a signal ends it.
    void read();

  private:
    // A file whose frames have their times by the cadence.
    struct CadenceSpan {
        std::string path, session;
        int64_t first_id, last_id, first_ns, last_ns;
    };
    void read_names();
    void read_input(const std::string &name);
    void read_folder(const std::string &folder);
    void read_pair(const std::string &path);
    void read_cube(const std::string &path);
    std::vector<std::string> open_sides(const std::string &input) const;
    std::vector<std::string> sides_of(const std::string &input);
    void look_at(const std::string &side);
    FrameFacts facts_of(FrameFile &file);
    FrameTimes times_of(FrameFile &file, const FrameFacts &first);
    void remark_overlap(const FrameFile &file, const FrameFacts &first, const FrameTimes &times);
    void poll();
    void end();
    void name_half(const std::string &side);

    const DownlinkOptions &options_;
    Receiver &receiver_;
    std::map<std::string, Pair> growing_; // by their side files
    std::set<std::string> mute_;          // files of growing folders that were told to be unreadable
    std::set<std::string> gone_;          // inputs that are followed and cannot be opened
    std::map<std::string, int> halves_;   // looks that found one file of a pair alone
    std::string unnumbered_;              // the file without FRAME1 that had --session
    std::vector<CadenceSpan> spans_;
    bool told_beyond_ = false; // that the table of leap seconds has expired
};

} // namespace cli
