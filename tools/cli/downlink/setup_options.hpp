// Options of `track`, `rebuild` and `merge` for the setup of a state folder: grid, clock and time stamps.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <toliman/track.h>

#include "common/terminal.hpp"

namespace CLI {
class App;
}

namespace cli {

class SetupOptions {
  public:
    void add_to(CLI::App &command);
    bool has_grid() const { return !grid_.empty() || mission_days_; }
    bool has_clock() const { return !clock_.empty(); }
    bool has_timing() const { return !stamp_.empty() || exposure_s_; }
    // Sets what was given. The pairs of the clock remain in this object. Warnings about the clock go to `progress`.
    void set(toliman_track_options &how, Progress &progress);
    // Warns that a folder whose setup is lost has lost the reference of its time stamps, too, unless it was given.
    void warn_of_lost_timing(const std::string &folder, Progress &progress) const;
    // Grid, epoch and clock as they were given: " --grid 1e-3:1e-5:5000 --clock clock.csv".
    std::string text() const;

  private:
    std::string grid_, clock_, stamp_;
    std::optional<double> mission_days_, exposure_s_;
    std::optional<int64_t> epoch_;
    std::vector<int64_t> pairs_;
};

} // namespace cli
