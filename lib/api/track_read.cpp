// include/toliman/track.h: queries of a tracker.
#include <toliman/track.h>
#include <toliman/track_goodness.h>
#include <toliman/track_records.h>

#include "api/common.hpp"
#include "api/peak.hpp"
#include "api/track_handle.hpp"
#include "api/track_results.hpp"
#include "track/folder_goodness.hpp"

using namespace toliman;
using namespace toliman::api;

extern "C" {

toliman_status toliman_track_get_records(const toliman_track *track, int64_t first, size_t count,
                                         toliman_track_record *records, size_t *done) noexcept {
    return call(track, "track", [&](auto &self) {
        const track::Tracker &tracker = *self.tracker;
        required(done, "done");
        if (first < 0)
            fail(Status::range, "{first} = %lld: must be at least 0", static_cast<long long>(first));
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
    return call(track, "track", [&](auto &self) {
        const std::vector<track::Column> &all = self.tracker->columns().all();
        const StructOutput<toliman_track_column> result(columns, "columns", capacity, count);
        result.write(all.size(), "columns", [&](size_t i) { return public_column(all[i]); });
    });
}

toliman_status toliman_track_get_column(const toliman_track *track, const char *name, int64_t first, size_t count,
                                        double *values, size_t *done) noexcept {
    return call(track, "track", [&](auto &self) {
        const track::Columns &columns = self.tracker->columns();
        required(done, "done");
        const size_t at = columns.find(&required(name, "name"));
        if (at == columns.count())
            fail(Status::not_found, "{name} = \"%.64s\": is not a column of the ledger", name);
        if (first < 0)
            fail(Status::range, "{first} = %lld: must be at least 0", static_cast<long long>(first));
        required_array(values, count, sizeof *values, "values");
        size_t written = 0;
        self.tracker->visit(static_cast<uint64_t>(first), count,
                            [&](const track::Record &record, const track::Outcome &) {
                                values[written++] = columns.all()[at].number(record.cells[at]);
                            });
        *done = written;
    });
}

toliman_status toliman_track_get_intervals(const toliman_track *track, int64_t record, double *intervals,
                                           size_t capacity, size_t *count) noexcept {
    return call(track, "track", [&](auto &self) {
        const track::Tracker &tracker = *self.tracker;
        const Output<double> result(intervals, "intervals", capacity, count, 2);
        if (self.options.folder == nullptr)
            fail(Status::state, "{track}: is in memory, which keeps no intervals");
        if (record < 0 || static_cast<uint64_t>(record) >= tracker.records())
            fail(Status::range, "{record} = %lld: must be in [0, %llu)", static_cast<long long>(record),
                 static_cast<unsigned long long>(tracker.records()));
        const std::vector<double> found = tracker.intervals_of(static_cast<uint64_t>(record));
        std::copy(found.begin(), found.end(), result.resize(found.size() / 2, "intervals"));
    });
}

toliman_status toliman_track_get_options(const toliman_track *track, toliman_track_options *options) noexcept {
    return call(track, "track", [&](auto &self) { deliver(self.options, options, "options"); });
}

toliman_status toliman_track_get_info(const toliman_track *track, toliman_track_info *out) noexcept {
    return call(track, "track",
                [&](auto &self) { deliver(public_info(*self.tracker, self.options.flags), out, "out"); });
}

toliman_status toliman_track_get_streams(const toliman_track *track, toliman_track_stream *streams, size_t capacity,
                                         size_t *count) noexcept {
    return call(track, "track", [&](auto &self) {
        const track::Tracker &tracker = *self.tracker;
        const StructOutput<toliman_track_stream> result(streams, "streams", capacity, count);
        const std::vector<track::NamedStream> all = tracker.streams();
        result.write(all.size(), "sessions and regions", [&](size_t i) { return public_stream(all[i]); });
    });
}

toliman_status toliman_track_query_fit(const toliman_track *track, toliman_period_peak *out) noexcept {
    return call(track, "track", [&](auto &self) {
        required(out, "out");
        const track::Series series = self.tracker->series();
        period::Samples samples = {series.t.data(), series.y.data(), series.sigma.data(), series.t.size()};
        samples.columns = series.rows.data();
        const period::Stream &stream = self.period.stream;
        deliver(public_fit(stream, samples), out, "out");
    });
}

toliman_status toliman_track_query_goodness(const toliman_track *track, toliman_track_goodness *out) noexcept {
    return query(track, "track", out, [&](auto &self, auto &made) {
        const track::Tracker &tracker = *self.tracker;
        const track::FolderGoodness found = track::folder_goodness(tracker);
        set_goodness(found.goodness, made);
        TOLIMAN_COPY(made, found, frames, years, trend_per_year, trend_sigma_per_year, poor, too_good, bad_pixels);
        TOLIMAN_COPY(made, found, cleaned);
        made.misfit = tracker.counts().misfit;
        made.chi_limit = tracker.chi_limit();
        const track::ModelVerdict &model = tracker.plan().model;
        TOLIMAN_COPY(made, model, is_calibrated, is_complete);
        made.calibration_chi_square = model.goodness.chi_square;
        made.calibration_chi_square_sigma = model.goodness.sigma;
        made.calibration_goodness = kGoodness.to_constant(model.goodness.verdict);
    });
}

toliman_status toliman_track_get_period(const toliman_track *track, const toliman_period **out) noexcept {
    return call(track, "track", [&](auto &self) { required(out, "out") = &self.period; });
}

} // extern "C"
