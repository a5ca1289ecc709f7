// Method: the instrument changes with time as a linear spline with nodes every `days` from the first frame at t_0 on. A
// frame at t has the window w = floor((t - t_0)/days), the share s = (t - t_0)/days - w, and the values
//     (1 - s) q_w + s q_(w+1).
// A window without frames exists only as the end of one with frames. Refining halves the windows, down to four frames
// in each on average.
// Photons are made absolute first: relative to the brightest pixel, they would change with each step of the optics.
#include "calibrate/problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/error.hpp"
#include "scene/instrument.hpp"

namespace toliman::calibrate {

namespace {

constexpr double kLeastPerWindow = 4;  // frames
constexpr double kRoundingPx2 = 1e-12; // of a jitter

} // namespace

double Frames::exposures() const noexcept {
    return std::accumulate(predictions.begin(), predictions.end(), 0.0,
                           [](double sum, const fit::Prediction &one) { return sum + one.spread.frames; });
}

bool Frames::has_sums() const noexcept {
    return std::any_of(predictions.begin(), predictions.end(), [](const auto &one) { return one.spread.any(); });
}

Spread Frames::mean_spread() const noexcept {
    Spread mean;
    const double all = exposures();
    for (const fit::Prediction &one : predictions) {
        const double weight = one.spread.frames / all;
        mean.xx += weight * one.spread.xx;
        mean.yy += weight * one.spread.yy;
        mean.xy += weight * one.spread.xy;
    }
    return mean;
}

void check_scene(const optics::Simulator &simulator) {
    const Scene &scene = simulator.scene();
    const char *const source = scene.source.c_str();
    if (scene.stars.size() < 2)
        fail(Status::unsupported, "%s: {stars}: a calibration needs two stars", source);
    if (simulator.plan().engine == optics::EngineKind::padded_fft)
        fail(Status::unsupported, "%s: a calibration needs the matrix DFT: the padded FFT has no derivatives", source);
}

Scene with_photons(const optics::Simulator &simulator) {
    Scene scene = simulator.scene();
    if (scene.cadence.peak_photons == 0)
        return scene;
    scene.cadence.peak_photons = 0;
    scene.cadence.exposure_s = 1;
    if (scene.detector.sidelobe)
        scene.detector.sidelobe->efficiency = 1; // the light has it
    for (size_t star = 0; star < scene.stars.size(); star++)
        scene.stars[star].photons_per_s = optics::photons_before_qe(simulator.light(), star);
    return scene;
}

namespace {

std::vector<Window> windows_of(const std::vector<fit::Prediction> &predictions, double days) {
    const double first = std::min_element(predictions.begin(), predictions.end(), [](const auto &a, const auto &b) {
                             return a.days < b.days;
                         })->days;
    std::map<double, Window> windows; // by their number
    for (size_t k = 0; k < predictions.size(); k++) {
        const double elapsed = predictions[k].days - first, number = days > 0 ? std::floor(elapsed / days) : 0,
                     share = days > 0 ? std::clamp(elapsed / days - number, 0.0, 1.0) : 0;
        windows[number].frames.push_back(k);
        windows[number].shares.push_back(share);
        if (share > 0)
            windows[number + 1];
    }
    std::vector<Window> all;
    double before = -1;
    for (auto &[number, window] : windows) {
        window.first_days = days > 0 ? first + number * days : first;
        window.elapsed = number - before;
        before = number;
        all.push_back(std::move(window));
    }
    return all;
}

} // namespace

void set_windows(Problem &problem, double days) {
    problem.window_days = days;
    problem.windows = windows_of(problem.frames.predictions, days);
}

bool refine_windows(Problem &problem) {
    const std::vector<fit::Prediction> &predictions = problem.frames.predictions;
    const auto [first, last] = std::minmax_element(predictions.begin(), predictions.end(),
                                                   [](const auto &a, const auto &b) { return a.days < b.days; });
    const double span = last->days - first->days, days = problem.window_days > 0 ? problem.window_days / 2 : span;
    if (!(days > 0) || static_cast<double>(predictions.size()) * days < kLeastPerWindow * span)
        return false;
    std::vector<Window> finer = windows_of(predictions, days);
    if (finer.size() <= problem.windows.size() || finer.size() * problem.free.size() > kMostUnknowns)
        return false;
    problem.window_days = days;
    problem.windows = std::move(finer);
    return true;
}

std::vector<double> mean_of(const std::vector<std::vector<double>> &windows) {
    std::vector<double> mean(windows[0].size());
    for (const std::vector<double> &window : windows)
        for (size_t i = 0; i < mean.size(); i++)
            mean[i] += window[i] / static_cast<double>(windows.size());
    return mean;
}

std::vector<std::vector<double>> at_starts(const std::vector<std::vector<double>> &values,
                                           const std::vector<Window> &from, const std::vector<Window> &to) {
    std::vector<std::vector<double>> all;
    size_t next = 0; // the first start after that of `to`, or the last
    for (const Window &window : to) {
        while (next + 1 < from.size() && from[next].first_days < window.first_days)
            next++;
        const size_t before = next > 0 ? next - 1 : 0;
        const double step = from[next].first_days - from[before].first_days,
                     share = step > 0 ? std::clamp((window.first_days - from[before].first_days) / step, 0.0, 1.0) : 0;
        all.push_back(sum_of(values, {{before, 1 - share}, {next, share}}));
    }
    return all;
}

std::vector<double> sum_of(const std::vector<std::vector<double>> &windows, const std::vector<Part> &parts) {
    std::vector<double> sum(windows[0].size());
    for (const Part &part : parts)
        for (size_t i = 0; i < sum.size(); i++)
            sum[i] += part.share * windows[part.window][i];
    return sum;
}

// sqrt(sum a m^2 / sum a) with the amplitude a of each cell: cells behind struts have no influence.
double rms_of(const Buffer<double> &map_m, const Buffer<double> &amplitude) noexcept {
    double square = 0, open = 0;
    for (size_t cell = 0; cell < map_m.size(); cell++) {
        square += amplitude[cell] * map_m[cell] * map_m[cell];
        open += amplitude[cell];
    }
    return open > 0 ? std::sqrt(square / open) : 0;
}

void change_response(const Buffer<double> &change, Detector &detector) {
    if (detector.response.empty())
        detector.response.assign(change.size(), 1.0);
    for (size_t i = 0; i < change.size(); i++)
        detector.response[i] *= 1 + change[i];
}

Scene scene_at(const Problem &problem, const std::vector<double> &changes) {
    Scene scene = problem.nominal;
    for (size_t i = 0; i < problem.free.size(); i++)
        adjust(scene, problem.free[i].parameter, changes[i]);
    Jitter &jitter = scene.systematics.jitter, possible = jitter;
    if (scene.detector.diffusion_px2 == 0 && make_possible(possible) &&
        std::hypot(possible.xx - jitter.xx, possible.yy - jitter.yy, possible.xy - jitter.xy) < kRoundingPx2)
        jitter = possible; // it is at its bound
    return scene;
}

optics::Outline outline_at(const Problem &problem, const std::vector<double> &changes, const Buffer<double> &map_m) {
    optics::Outline outline = optics::outline_of(scene_at(problem, changes), problem.settings);
    for (size_t i = 0; i < map_m.size(); i++)
        outline.pupil.opd_m[i] += map_m[i];
    return outline;
}

} // namespace toliman::calibrate
