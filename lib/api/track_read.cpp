// include/toliman/track.h: queries of a tracker.
#include <algorithm>
#include <vector>

#include <toliman/track.h>
#include <toliman/track_goodness.h>
#include <toliman/track_records.h>

#include "api/guard.hpp"
#include "api/peak.hpp"
#include "api/struct_array.hpp"
#include "api/track_handle.hpp"
#include "api/track_results.hpp"
#include "track/folder_goodness.hpp"

using namespace toliman;
using namespace toliman::api;

extern "C" {

toliman_status toliman_track_get_records(const toliman_track *track, int64_t first, size_t count,
                                         toliman_track_record *records, size_t *done) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const track::Tracker &tracker = *use->tracker;
        required(done, "done");
        if (first < 0)
            fail(Status::argument, "{first} = %lld: must be at least 0", static_cast<long long>(first));
        size_t written = 0;
        if (count == 0) {
            *done = 0;
            return;
        }
        const StructArray<toliman_track_record> found(records, "records");
        tracker.visit(static_cast<uint64_t>(first), count,
                      [&](const track::Record &record, const track::Outcome &outcome) {
                          found.put(written++, public_record(record, outcome));
                      });
        *done = written;
    });
}

toliman_status toliman_track_get_columns(const toliman_track *track, toliman_track_column *columns, size_t capacity,
                                         size_t *count) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const std::vector<track::Column> &all = use->tracker->columns().all();
        required(count, "count");
        if (capacity > 0) {
            const StructArray<toliman_track_column> found(columns, "columns");
            if (capacity < all.size())
                fail(Status::capacity, "{capacity} = %zu: must be at least %zu, the number of columns", capacity,
                     all.size());
            for (size_t i = 0; i < all.size(); i++)
                found.put(i, public_column(all[i]));
        }
        *count = all.size();
    });
}

toliman_status toliman_track_get_column(const toliman_track *track, const char *name, int64_t first, size_t count,
                                        double *values, size_t *done) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const track::Columns &columns = use->tracker->columns();
        required(done, "done");
        const size_t at = columns.find(&required(name, "name"));
        if (at == columns.count())
            fail(Status::not_found, "{name} = \"%.64s\": is not a column of the ledger", name);
        if (first < 0)
            fail(Status::argument, "{first} = %lld: must be at least 0", static_cast<long long>(first));
        required_array(values, count, sizeof *values, "values");
        size_t written = 0;
        use->tracker->visit(static_cast<uint64_t>(first), count,
                            [&](const track::Record &record, const track::Outcome &) {
                                values[written++] = columns.all()[at].number(record.cells[at]);
                            });
        *done = written;
    });
}

toliman_status toliman_track_get_intervals(const toliman_track *track, int64_t record, double *intervals,
                                           size_t capacity, size_t *count) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const track::Tracker &tracker = *use->tracker;
        required(count, "count");
        if (use->options.folder == nullptr)
            fail(Status::state, "{track}: is in memory, which keeps no intervals");
        if (record < 0 || static_cast<uint64_t>(record) >= tracker.records())
            fail(Status::argument, "{record} = %lld: must be in [0, %llu)", static_cast<long long>(record),
                 static_cast<unsigned long long>(tracker.records()));
        const std::vector<double> found = tracker.intervals_of(static_cast<uint64_t>(record));
        if (intervals == nullptr && capacity > 0)
            fail(Status::argument, "{intervals} is NULL");
        if (intervals != nullptr && capacity < found.size() / 2)
            fail(Status::capacity, "{capacity} = %zu: must be at least %zu, the number of intervals", capacity,
                 found.size() / 2);
        if (intervals != nullptr)
            std::copy(found.begin(), found.end(), intervals);
        *count = found.size() / 2;
    });
}

toliman_status toliman_track_get_options(const toliman_track *track, toliman_track_options *options) noexcept {
    return guard([&] {
        const Use use(track, "track");
        deliver(use->options, options, "options");
    });
}

toliman_status toliman_track_get_info(const toliman_track *track, toliman_track_info *out) noexcept {
    return guard([&] {
        const Use use(track, "track");
        deliver(public_info(*use->tracker, use->flags), out, "out");
    });
}

toliman_status toliman_track_get_rejected(const toliman_track *track, int32_t reason, int64_t *frames) noexcept {
    return guard([&] {
        const Use use(track, "track");
        required(frames, "frames");
        *frames = use->tracker->counts().rejected[static_cast<size_t>(kRejections.to_enum(reason, "reason"))];
    });
}

toliman_status toliman_track_get_streams(const toliman_track *track, toliman_track_stream *streams, size_t capacity,
                                         size_t *count) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const track::Tracker &tracker = *use->tracker;
        required(count, "count");
        if (capacity > 0) {
            const StructArray<toliman_track_stream> found(streams, "streams");
            if (capacity < tracker.stream_count())
                fail(Status::capacity, "{capacity} = %zu: must be at least %zu, the number of sessions and regions",
                     capacity, tracker.stream_count());
            const std::vector<track::NamedStream> all = tracker.streams();
            for (size_t i = 0; i < all.size(); i++)
                found.put(i, public_stream(all[i]));
        }
        *count = tracker.stream_count();
    });
}

toliman_status toliman_track_get_clock(const toliman_track *track, int64_t *clock, size_t capacity,
                                       size_t *points) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const std::vector<track::ClockPoint> &known = use->tracker->plan().clock.points();
        required(points, "points");
        if (clock == nullptr && capacity > 0)
            fail(Status::argument, "{clock} is NULL");
        if (clock != nullptr && capacity < known.size())
            fail(Status::capacity, "{capacity} = %zu: must be at least %zu, the number of clock pairs", capacity,
                 known.size());
        for (size_t i = 0; clock != nullptr && i < known.size(); i++) {
            clock[2 * i] = known[i].camera_ns;
            clock[2 * i + 1] = known[i].tai_ns;
        }
        *points = known.size();
    });
}

toliman_status toliman_track_query_fit(const toliman_track *track, toliman_period_peak *out) noexcept {
    return guard([&] {
        const Use use(track, "track");
        required(out, "out");
        const track::Series series = use->tracker->series();
        period::Samples samples = {series.t.data(), series.y.data(), series.sigma.data(), series.t.size()};
        samples.columns = series.rows.data();
        const period::Stream &stream = use->period.stream;
        deliver(public_fit(stream, samples), out, "out");
    });
}

toliman_status toliman_track_query_goodness(const toliman_track *track, toliman_track_goodness *out) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const track::Tracker &tracker = *use->tracker;
        const track::FolderGoodness found = track::folder_goodness(tracker);
        toliman_track_goodness made = {};
        set_goodness(found.goodness, made);
        made.frames = found.frames;
        made.years = found.years;
        made.trend_per_year = found.trend_per_year;
        made.trend_sigma_per_year = found.trend_sigma_per_year;
        made.poor = found.poor;
        made.too_good = found.too_good;
        made.misfit = tracker.counts().misfit;
        made.bad_pixels = found.bad_pixels;
        made.cleaned = found.cleaned;
        made.chi_limit = tracker.chi_limit();
        const track::ModelVerdict &model = tracker.plan().model;
        made.is_calibrated = model.is_calibrated ? 1 : 0;
        made.is_complete = model.is_complete ? 1 : 0;
        made.calibration_chi_square = model.goodness.chi_square;
        made.calibration_chi_square_sigma = model.goodness.sigma;
        made.calibration_goodness = kGoodness.to_constant(model.goodness.verdict);
        deliver(made, out, "out");
    });
}

toliman_status toliman_track_get_period(const toliman_track *track, const toliman_period **out) noexcept {
    return guard([&] {
        const Use use(track, "track");
        required(out, "out") = &use->period;
    });
}

} // extern "C"
