// Folders of `toliman track`: opened for whatever is done with them, and what they tell.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <toliman/toliman.hpp>

#include "json.hpp"
#include "periodogram.hpp"

namespace cli {

// What a folder was made with; none for one that holds no state yet.
std::optional<toliman_track_options> made_with(const std::string &folder);
// The same of one that must hold a state; `folder` must outlive it.
toliman_track_options known_state(const std::string &folder);
// A Failure with exit code 5 where the state is damaged.
toliman::tracker open_tracker(const toliman_track_options &options);
toliman_track_info info_of(const toliman::tracker &tracker);
// Whether its clock changes the camera's time.
bool has_clock(const toliman::tracker &tracker);

// "F0:DF:NF", cycles a day.
FrequencyGrid grid_of(const std::string &text);
void set_grid(const FrequencyGrid &grid, toliman_track_options &options);
// Pairs camera_ns,tai_ns of a CSV file, one after the other.
std::vector<int64_t> read_clock(const std::string &path);
void set_clock(const std::vector<int64_t> &clock, toliman_track_options &options);

// The period as far as frames tell; NaN else. Of a look after each frame the highest peak of the grid; `fit` is the
// least-squares fit to all values, which are read anew for it.
enum class Fit { none, made };
class PeriodFacts {
  public:
    PeriodFacts(const toliman::tracker &tracker, Fit fit);
    void add_to(Json &json) const;
    std::string text() const;

  private:
    int64_t count_;
    double sequential_;
    toliman_period_peak peak_ = {}, fit_ = {};
};

void add_counts(const toliman_track_info &info, Json &json);

} // namespace cli
