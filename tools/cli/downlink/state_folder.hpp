// Folders of `toliman track`: opened for whatever is done with them, and what they tell.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/json.hpp"
#include "common/terminal.hpp"

namespace cli {

// What a folder was made with; none for one that holds no state yet. `folder` must outlive it. A Failure for a folder
// that cannot be opened, and with exit code 5 for one that is damaged.
std::optional<toliman_track_options> made_with(const std::string &folder);
// The same of one that must hold a state.
toliman_track_options known_state(const std::string &folder);
// The same to look at it, beside its writer if need be; a Failure also where its grid and clock are lost.
toliman_track_options state_to_read(const std::string &folder);
// A Failure with exit code 5 where the state is damaged, and 6 where another process is writing to it. What is damaged
// and can be done without is told.
toliman::tracker open_tracker(toliman_track_options options, Progress &progress);
toliman_track_info info_of(const toliman::tracker &tracker);
// Frames rejected for each reason, by its name.
std::vector<std::pair<std::string, int64_t>> rejected_of(const toliman::tracker &tracker);
// Pairs of camera's time and TAI, one after the other; none where they are the same.
std::vector<int64_t> clock_of(const toliman::tracker &tracker);
// Removes the files of a state folder, the ledger last, and the folder if nothing else is in it.
void remove_state(const std::string &folder);
// The last message of the library, which failed with this status upon a folder that is damaged, and what to do.
std::string damage_of(toliman_status status, const std::string &folder);

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
    std::string unit_; // of time
    toliman_period_peak peak_ = {}, fit_ = {};
};

void add_counts(const toliman::tracker &tracker, Json &json);

} // namespace cli
