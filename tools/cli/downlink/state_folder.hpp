// State folders of `toliman track`: opens them, prints counts, and gives their frames as a series.
#pragma once
#include "frames/predictions.hpp"
#include "series/nuisance.hpp"

namespace cli {

// Settings of a folder, or none if it has no ledger of frames yet. `folder` must outlive them. Throws Failure if it
// cannot be opened, with exit code 5 if it is damaged.
std::optional<toliman_track_options> made_with(const std::string &folder);
// The same for a folder that must have a ledger.
toliman_track_options known_state(const std::string &folder);
// The same for reading, also while another process writes. Failure also if the setup is lost.
toliman_track_options state_to_read(const std::string &folder);
// Throws Failure with exit code 5 if the state is damaged, and 6 if another process writes to it. Warns of damage that
// was repaired.
toliman::tracker open_tracker(toliman_track_options options, Progress &progress);
toliman_track_info info_of(const toliman::tracker &tracker);
// Options in force; folder and clock belong to the tracker.
toliman_track_options settings_of(const toliman::tracker &tracker);
// Removes the files of a state folder, the ledger last, and the folder if it is then empty.
void remove_state(const std::string &folder);
// The message of the library for a damaged folder, and the remedy.
std::string damage_text(toliman_status status, const std::string &folder);

void add_timing(const toliman_track_options &settings, Json &json);
void add_counts(const toliman::tracker &tracker, Json &json);
std::string counts_text(const toliman::tracker &tracker); // a line per count

// The separations of all accepted and unreduced frames of a folder. plate_scale: arcsec per px; otherwise that of the
// folder. Warns of frames whose time on target is not known, which are left out.
toliman::measurements measured_frames(const std::string &folder, const std::optional<double> &plate_scale,
                                      Progress &progress);

// The values of all accepted frames, with the functions of the sums. flags: TOLIMAN_SERIES_PLAIN_TIMES for times in
// units of the grid. Throws Failure if there is none.
toliman::measurements accepted_frames(const toliman::tracker &tracker, uint32_t flags = 0);

// What to do with a folder whose frames are reduced to an orbit refitted to them.
std::string orbit_before_refit(const std::string &folder);

// A time in TAI, in units of unit_ns since time_offset_ns.
double time_of(int64_t tai_ns, const toliman_track_options &how);

// The columns of the periodogram: elements of the orbit whose errors are fitted. The coefficients are in px, the errors
// in units of the elements.
std::vector<Function> element_columns(const toliman::tracker &tracker);

} // namespace cli
