// Definition of toliman_measure.
#pragma once
#include <toliman/measure.h>

#include "api/choice.hpp"
#include "api/handle.hpp"
#include "measure/series.hpp"

struct toliman_measure : toliman::api::Handle<toliman_measure> {
    static constexpr char kType[] = "toliman_measure";
    toliman::measure::Series series;
};

namespace toliman::api {

constexpr Choice<measure::Kind> kMeasureKinds = {TOLIMAN_MEASURE_VALUE, TOLIMAN_MEASURE_VELOCITY,
                                                 "TOLIMAN_MEASURE_..."};

// Of a tracker, in api/track_measure.cpp.
measure::Series series_of(const toliman_track &track, const toliman_measure_options &options);
// The tracker of a state folder, for reading.
measure::Series series_of_folder(const char *folder, const toliman_measure_options &options);

} // namespace toliman::api
