// Goodness of fit of the frames of a state folder, as text and JSON.
#pragma once
#include <string>

#include <toliman/toliman.hpp>

#include "common/json.hpp"

namespace cli {

toliman_track_goodness goodness_of(const toliman::tracker &tracker);
// Lines of `status`, each indented.
std::string goodness_text(const toliman_track_goodness &goodness);
Json goodness_json(const toliman_track_goodness &goodness);
// What is wrong with the model of the frames, in a sentence; "" if nothing is.
std::string model_complaint(const toliman_track_goodness &goodness);

} // namespace cli
