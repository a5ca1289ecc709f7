// include/toliman/track_records.h: the frames of a tracker as a series; measure.h: those of a state folder.
#include <toliman/track_records.h>

#include "api/common.hpp"
#include "api/measure_handle.hpp"
#include "api/track_handle.hpp"
#include "measure/folder.hpp"

using namespace toliman;
using namespace toliman::api;

namespace toliman::api {

namespace {

struct Destroy {
    void operator()(toliman_track *track) const noexcept { toliman_track_destroy(track); }
};

// Options that the ledger has already fixed.
void check_options(const toliman_measure_options &options) {
    const std::pair<const char *, bool> given[] = {
        {"columns", options.columns != nullptr},     {"instrument", options.instrument != nullptr},
        {"functions", options.functions != nullptr}, {"time_format", options.time_format != 0},
        {"time_scale", options.time_scale != 0},     {"exposure_s", options.exposure_s != 0}};
    for (const auto &[name, is_given] : given)
        if (is_given)
            fail(Status::argument, "{options->%s}: must not be given for the frames of a tracker", name);
}

} // namespace

measure::Series series_of(const toliman_track &track, const toliman_measure_options &options) {
    check_options(options);
    const track::Tracker &tracker = *track.tracker;
    const bool is_measured = options.kind == TOLIMAN_MEASURE_SEPARATION;
    if ((options.flags & ~(is_measured ? 0 : TOLIMAN_SERIES_PLAIN_TIMES)) != 0)
        fail(Status::argument, "{options->flags} = %u: must be 0, or TOLIMAN_SERIES_PLAIN_TIMES for the values",
             options.flags);
    measure::Series series = is_measured ? measure::separations_of(tracker)
                                         : measure::values_of(tracker, track.period.stream.grid(),
                                                              (options.flags & TOLIMAN_SERIES_PLAIN_TIMES) != 0);
    const measure::Kind kind = options.kind != 0 ? kMeasureKinds.to_enum(options.kind) : series.kind;
    if (kind != series.kind)
        fail(Status::argument, "{options->kind} = %d: the values of the frames are %s", options.kind,
             toliman_constant_name(kMeasureKinds.to_constant(series.kind)));
    if (!(options.unit >= 0 && options.unit <= 1e100))
        fail(Status::argument, "{options->unit} = %g: must be in (0, 1e100], or 0", options.unit);
    if (series.kind == measure::Kind::reduced && options.unit != 0 && options.unit != series.unit)
        fail(Status::argument, "{options->unit} = %g: must be 0 for reduced frames: that of the reduction is %g arcsec",
             options.unit, series.unit);
    if (options.unit != 0)
        series.unit = options.unit;
    series.name = track.folder;
    check(series);
    return series;
}

// Status and message are those of the tracker.
measure::Series series_of_folder(const char *folder, const toliman_measure_options &options) {
    toliman_track_options how = {};
    how.struct_size = sizeof how;
    check_again(toliman_track_load_options(folder, &how));
    how.flags |= TOLIMAN_TRACK_READ_ONLY;
    TOLIMAN_COPY(how, options, log, log_data);
    toliman_track *made = nullptr;
    check_again(toliman_track_create(&how, &made));
    const std::unique_ptr<toliman_track, Destroy> track(made);
    try {
        return series_of(*track, options);
    } catch (const Error &error) {
        fail_within(error, error.status(), "{%s}: %s", folder, error.what());
    }
}

} // namespace toliman::api

extern "C" {

toliman_status toliman_track_get_measure(const toliman_track *track, const toliman_measure_options *options,
                                         toliman_measure **out) noexcept {
    return call(track, "track", [&](auto &self) {
        toliman_measure *&made = required(out, "out");
        made = new toliman_measure{{}, series_of(self, accept(options, "options"))};
    });
}

} // extern "C"
