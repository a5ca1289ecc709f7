#include "frames/predictions.hpp"

#include <toliman/toliman.hpp>

#include "common/failure.hpp"

namespace cli {

Predictions::Predictions(const std::vector<double> &scene_times, size_t most, const std::optional<double> &cadence)
    : scene_times_(scene_times), cadence_(cadence), predictions_(most, toliman::sized<toliman_fit_prediction>()) {}

void Predictions::open(FrameFile &frames) {
    path_ = frames.path();
    file_times_ = frames.days();
    if (frames.counted())
        check_times(frames.count());
}

const toliman_fit_prediction *Predictions::from(size_t first, size_t count) {
    check_times(first + count);
    for (size_t i = 0; i < count; i++)
        predictions_[i].time_days = days_of(first + i);
    return predictions_.data();
}

void Predictions::check_times(size_t frames) const {
    if (!cadence_ && frames > times().size())
        malformed(path_, "has " + std::to_string(frames) + " frames: the scene has times for " +
                             std::to_string(times().size()) + " only: give --cadence SECONDS");
}

double Predictions::days_of(size_t frame) const {
    constexpr double kDay = 86400;
    return cadence_ ? static_cast<double>(frame) * *cadence_ / kDay : times()[frame];
}

} // namespace cli
