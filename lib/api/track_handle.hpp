// Definition of toliman_track.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <toliman/track.h>

#include "api/handles.hpp"
#include "track/tracker.hpp"

struct toliman_track : toliman::api::Handle<toliman_track> {
    static constexpr char kType[] = "toliman_track";
    toliman_period period;
    std::optional<toliman::track::Tracker> tracker = {};
    toliman_track_estimator estimator = {};
    const toliman_sky *sky = nullptr;   // of the reduction, if given
    toliman_track_options options = {}; // in effect, for get_options; folder and clock point to the next two members
    std::string folder = {};
    std::vector<int64_t> clock = {};
};
