#include "frames/predictions.hpp"

#include "api/header_keys.hpp"
#include "frames/frames_out.hpp"

namespace cli {

namespace {

using toliman::api::kHeaderKeys;

// Nothing where the header has no time.
std::optional<toliman_ingest_header_time> header_time(FrameFile &file, const LeapSeconds &leap_seconds) {
    auto header = toliman::sized<toliman_ingest_header>();
    auto time = toliman::sized<toliman_ingest_header_time>();
    std::vector<std::optional<std::string>> values;
    for (const auto &[key, member] : kHeaderKeys)
        values.push_back(file.value_of(key));
    for (size_t i = 0; i < values.size(); i++)
        header.*kHeaderKeys[i].second = values[i] ? values[i]->c_str() : nullptr;
    const toliman_status status = toliman_ingest_read_header(&header, leap_seconds.rows.data(),
                                                             leap_seconds.rows.size(), leap_seconds.expires, &time);
    if (status == TOLIMAN_E_NOT_FOUND)
        return std::nullopt;
    if (status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_RANGE)
        malformed(file.path(), toliman_last_error());
    toliman::check(status);
    return time;
}

// Of a header without time: that of the camera, XPOSURE, or EXPTIME; 0 without all.
double exposure_of(FrameFile &file) {
    constexpr double kLongest = 1e9; // s
    if (file.exposure_s() > 0)
        return file.exposure_s();
    for (const char *key : {"XPOSURE", "EXPTIME"}) {
        const std::optional<std::string> text = file.value_of(key);
        double seconds = 0;
        if (!text)
            continue;
        std::string number = *text; // FITS also allows the exponent D
        std::replace(number.begin(), number.end(), 'D', 'E');
        if (!number_of(number, seconds) || !(seconds >= 0 && seconds <= kLongest))
            malformed(file.path(), key + (" = " + *text) + ": must be from 0 to 1e9 s");
        return seconds;
    }
    return 0;
}

// The column time_days of the table FRAMES, ns.
std::vector<int64_t> table_of(FrameFile &file) {
    constexpr double kMost = 20000; // so that sums of times fit
    std::vector<int64_t> times;
    for (const double days : file.days()) {
        if (!(std::fabs(days) <= kMost))
            malformed(file.path(),
                      "table FRAMES: a time of " + std::to_string(days) + " days: must be within 20,000 days");
        times.push_back(*ns_of_days(days));
    }
    return times;
}

__extension__ using Wide = __int128; // for differences of any two times

} // namespace

int32_t stamp_of(const std::string &word) noexcept {
    const auto found = std::find(std::begin(kStamps), std::end(kStamps), word);
    return found == std::end(kStamps) ? 0 : TOLIMAN_FRAME_STAMP_START + static_cast<int32_t>(found - kStamps);
}

FrameTimes::FrameTimes(FrameFile &file, int64_t number, const std::optional<double> &cadence,
                       const LeapSeconds &leap_seconds, int64_t time_zero_ns)
    : path_(file.path()), header_(header_time(file, leap_seconds)), steps_(table_of(file)), cadence_(cadence),
      exposure_s_(header_ ? header_->exposure_s : exposure_of(file)) {
    stamps_ = is_tai() || !steps_.empty() ? std::vector<int64_t>() : file.camera_ns();
    if (by_camera()) {
        rule_ = file.exposure_s() > 0 ? "the middle of the exposure by the camera's clock" : "the camera's clock";
        return;
    }
    const bool by_table = !steps_.empty(), has_more = file.count() > 1;
    if (!by_table && !cadence_ && !is_tai())
        malformed(path_, "tells no time: needs --cadence SECONDS");
    if (!by_table && !cadence_ && has_more)
        malformed(path_, "tells the time of its first frame only: needs --cadence SECONDS");
    const int64_t start = by_table ? steps_.front() : 0;
    for (int64_t &step : steps_)
        step -= start;
    first_ = is_tai() ? header_->tai_ns : start;
    if (!is_tai() && __builtin_add_overflow(start, time_zero_ns, &first_))
        malformed(path_, "its first time is beyond 64 bits");
    by_cadence_ = !by_table && (!is_tai() || has_more);
    number_ = by_table || is_tai() ? 0 : number;
    const std::string step = by_table ? "its table FRAMES" : number_ != 0 ? "FRAME1 and --cadence" : "--cadence";
    if (is_tai())
        rule_ = header_->rule + (has_more ? ", from there on by " + step : "");
    else
        rule_ = step + ", by the camera's clock";
}

std::optional<FrameTimes> FrameTimes::of_header(FrameFile &file, const std::optional<double> &cadence,
                                                const LeapSeconds &leap_seconds) {
    if (!header_time(file, leap_seconds) && (!file.days().empty() || file.camera_ns().empty()))
        return std::nullopt;
    return FrameTimes(file, 0, cadence, leap_seconds);
}

int64_t FrameTimes::at(size_t frame) const {
    constexpr double kMost = 4e18; // ns, so that sums of times fit
    if (by_camera())
        return stamps_[frame];
    const int64_t number = number_ + static_cast<int64_t>(frame);
    const double step = steps_.empty() && number != 0 ? static_cast<double>(number) * *cadence_ * 1e9 : 0;
    if (!(std::fabs(step) < kMost))
        malformed(path_, "frame " + std::to_string(number) + " is more than 4e9 s from frame 0");
    int64_t time = 0;
    if (__builtin_add_overflow(first_, steps_.empty() ? std::llround(step) : steps_[frame], &time))
        malformed(path_, "the time of frame " + std::to_string(number) + " is beyond 64 bits");
    return time;
}

Predictions::Predictions(const std::vector<double> &scene_times, size_t most, const FrameClock &clock,
                         Progress &progress)
    : scene_times_(scene_times), clock_(clock), progress_(progress),
      predictions_(most, toliman::sized<toliman_fit_prediction>()) {}

void Predictions::open(FrameFile &frames) {
    path_ = frames.path();
    file_times_ = frames.days();
    spreads_ = frames.spreads();
    dated_.reset();
    if (clock_.time_zero_ns || !frames.camera_ns().empty())
        dated_ = FrameTimes::of_header(frames, clock_.cadence, clock_.leap_seconds);
    if (dated_ && dated_->is_assumed())
        progress_.warn(path_ + ": time by " + dated_->rule());
    if (frames.counted())
        check_times(frames.count());
}

const toliman_fit_prediction *Predictions::from(size_t first, size_t count) {
    check_times(first + count);
    first_ = first;
    for (size_t i = 0; i < count; i++) {
        predictions_[i].time_days = days_of(first + i);
        predictions_[i].spread = spreads_.empty() ? nullptr : &spreads_[first + i];
    }
    return predictions_.data();
}

void Predictions::check_times(size_t frames) const {
    if (!dated_ && !clock_.cadence && frames > times().size())
        malformed(path_, "has " + std::to_string(frames) + " frames: the scene has times for " +
                             std::to_string(times().size()) + " only: give --cadence SECONDS");
}

double Predictions::days_of(size_t frame) const {
    constexpr double kDay = 86400;
    if (dated_)
        return static_cast<double>(Wide{dated_->at(frame)} - clock_.time_zero_ns.value_or(0)) / (kDay * 1e9);
    return clock_.cadence ? static_cast<double>(frame) * *clock_.cadence / kDay : times()[frame];
}

std::optional<int64_t> Predictions::tai_ns(size_t i) const {
    if (dated_)
        return dated_->at(first_ + i);
    return clock_.time_zero_ns ? frame_time(days(i), *clock_.time_zero_ns) : std::nullopt;
}

} // namespace cli
