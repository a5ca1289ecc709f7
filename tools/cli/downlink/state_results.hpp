// Results of a state folder: as JSON, and as files that a report or a spreadsheet reads.
#pragma once
#include <string>

#include <toliman/toliman.hpp>

#include "common/json.hpp"
#include "downlink/state_folder.hpp"

namespace cli {

// Schema toliman-track-status/2.
Json status_json(const toliman::tracker &tracker, const toliman_track_options &how, const PeriodFacts &period);

// Writes result.json (schema toliman-state/1), series.csv and periodogram.csv, all or none; creates the folder.
void write_results(const toliman::tracker &tracker, const toliman_track_options &how, const std::string &folder);

} // namespace cli
