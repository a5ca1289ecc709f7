// Grid and clock of a tracker's folder, as `track` and `rebuild` are asked for them.
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
    // Sets what is asked for; the clock's pairs stay here. Warnings about the clock go to `progress`.
    void set(toliman_track_options &how, Progress &progress);
    // As they were given: " --grid 1e-3:1e-5:5000 --clock clock.csv".
    std::string text() const;

  private:
    std::string grid_, clock_;
    std::optional<double> mission_days_;
    std::optional<int64_t> epoch_;
    std::vector<int64_t> pairs_;
};

} // namespace cli
