// Checks frames of a caller and converts them for a tracker.
#pragma once
#include <toliman/track.h>

#include "api/choice.hpp"
#include "track/tracker.hpp"

namespace toliman::api {

constexpr int64_t kLargestSide = 65536;
constexpr double kLongestExposure = 1e9; // s
constexpr Choice<track::Stamp> kStamps = {TOLIMAN_FRAME_STAMP_START, TOLIMAN_FRAME_STAMP_END,
                                          "TOLIMAN_FRAME_STAMP_..."};

// Status::argument, naming the member, if frame i is impossible for a tracker with these terms.
void check_frame(const toliman_frame &given, size_t i, const track::Terms &terms);

// Converts a frame that has been checked, and back.
track::Frame frame_of(const toliman_frame &given);
toliman_frame public_frame(const track::Frame &frame) noexcept;

// Wraps the caller's function for misfits; empty without one.
track::Retry retry_of(const toliman_track_options &options, const track::Terms &terms);

} // namespace toliman::api
