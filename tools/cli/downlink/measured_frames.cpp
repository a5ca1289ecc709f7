#include "downlink/measured_frames.hpp"

#include <algorithm>
#include <cmath>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "downlink/state_folder.hpp"

namespace cli {

namespace {

constexpr size_t kBlock = 4096; // records that are read at once
constexpr double kMjdOf1970 = 40587, kNsPerDay = 86400e9;

using Records = std::vector<toliman_track_record>;

bool has_separation(const toliman_track_record &record) {
    return record.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED || record.verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED;
}

class Frames {
  public:
    Frames(const std::string &folder, Progress &progress)
        : folder_(folder), tracker_(open_tracker(state_to_read(folder), progress)), info_(info_of(tracker_)),
          exposure_s_(settings_of(tracker_).exposure_s) {}

    const toliman_track_info &info() const noexcept { return info_; }
    size_t left_out() const noexcept { return left_out_; }

    void add_to(Measured &measured) {
        for (int64_t first = 0; first < info_.records; first += static_cast<int64_t>(kBlock))
            add_block(first, measured);
    }

  private:
    std::vector<double> column(const char *name, int64_t first, size_t count) const {
        std::vector<double> values(count);
        size_t done = 0;
        const toliman_status status =
            toliman_track_get_column(tracker_.get(), name, first, count, values.data(), &done);
        if (status == TOLIMAN_E_NOT_FOUND)
            malformed(folder_, std::string("has no column ") + name + ": must have frames measured by `track --fit`");
        toliman::check(status);
        return values;
    }

    void add_block(int64_t first, Measured &measured) {
        Records records(kBlock, toliman::sized<toliman_track_record>());
        size_t count = 0;
        toliman::check(toliman_track_get_records(tracker_.get(), first, kBlock, records.data(), &count));
        const auto separations = column("separation_px", first, count), exposures = column("exposure_s", first, count),
                   lists = column("intervals", first, count);
        for (size_t i = 0; i < count; i++) {
            if (!has_separation(records[i]))
                continue;
            if (records[i].reason == TOLIMAN_TRACK_REASON_NO_INTERVALS) {
                left_out_++;
                continue;
            }
            add_exposure(records[i], exposures[i], lists[i], measured.intervals);
            measured.series.t.push_back(kMjdOf1970 + static_cast<double>(records[i].tai_ns) / kNsPerDay);
            measured.series.y.push_back(separations[i]);
            measured.series.sigma.push_back(records[i].sigma);
        }
    }

    // The exposure of a frame, of zero length if it is not known. list: number of its on-target intervals.
    void add_exposure(const toliman_track_record &record, double exposure_s, double list,
                      std::vector<int64_t> &intervals) const {
        if (list != 0)
            malformed(folder_, formatted("frame %lld has a list of on-target intervals: must be frames without; give a "
                                         "series of their separations instead",
                                         static_cast<long long>(record.frame_id)));
        const double known_s = exposure_s > 0 ? exposure_s : exposure_s_;
        const int64_t length = std::llround(known_s * 1e9);
        int64_t start = 0, end = 0;
        if (__builtin_sub_overflow(record.tai_ns, length / 2, &start) || __builtin_add_overflow(start, length, &end))
            malformed(folder_, formatted("frame %lld: its exposure of %g s is beyond 64 bits of TAI in ns",
                                         static_cast<long long>(record.frame_id), known_s));
        intervals.insert(intervals.end(), {start, end});
    }

    const std::string &folder_;
    toliman::tracker tracker_;
    toliman_track_info info_;
    double exposure_s_; // of frames that do not state their own; 0: unknown
    size_t left_out_ = 0;
};

} // namespace

Measured measured_frames(const std::string &folder, const std::optional<double> &plate_scale, Progress &progress) {
    Frames frames(folder, progress);
    if (!plate_scale && !(frames.info().plate_scale_arcsec > 0))
        throw Failure(kExitUsage, folder + ": has no plate scale, as its frames are not reduced: give --plate-scale");
    Measured measured = {};
    measured.plate_scale = plate_scale_of(plate_scale, frames.info().plate_scale_arcsec);
    measured.series.name = folder;
    measured.series.time_scale = "TAI";
    frames.add_to(measured);
    if (measured.series.t.empty())
        malformed(folder, "has no accepted or unreduced frame whose time on target is known");
    if (frames.left_out() > 0)
        progress.warn(folder +
                      formatted(": %zu frames are left out, as their time on target is not known", frames.left_out()));
    return measured;
}

} // namespace cli
