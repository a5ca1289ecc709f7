#include "frames/predictions.hpp"

#include <utility>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"
#include "frames/frames_out.hpp"

namespace cli {

namespace {

__extension__ using Wide = __int128; // for differences of any two times

} // namespace

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
