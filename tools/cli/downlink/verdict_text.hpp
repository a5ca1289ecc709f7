// Frames, verdicts and warnings of `track`, as JSON and in words.
#pragma once
#include <exception>
#include <string>

#include <toliman/track.h>

#include "common/json.hpp"

namespace cli {

// The first keys of a line toliman-frame/2. frame: NULL if its name is unknown; has_time: its time is known, too;
// reason: NULL unless it is rejected.
Json frame_line(const toliman_frame *frame, bool has_time, const std::string &place, const char *verdict,
                const char *reason);

// The verdict on a frame that is not accepted, and its reason.
std::string verdict_text(const toliman_frame &frame, const toliman_track_outcome &outcome,
                         const toliman_track_options &settings);

// An accepted frame whose value is beyond the reach of noise.
std::string far_text(double value, double sigmas);

// Whether the clock table was extrapolated for a time.
bool is_outside_clock(const toliman_track_options &settings, int64_t camera_ns) noexcept;

// A line toliman-track-warning/1.
std::string warning_line(const std::string &warning, const std::string &input, const std::string &text);

// Advice at the end of a run that could not save.
const char *advice_after(const std::exception &error);

} // namespace cli
