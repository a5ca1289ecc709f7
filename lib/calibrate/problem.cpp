#include "calibrate/problem.hpp"

#include <cmath>

#include "scene/instrument.hpp"

namespace toliman::calibrate {

std::vector<double> mean_of(const std::vector<std::vector<double>> &windows) {
    std::vector<double> mean(windows[0].size());
    for (const std::vector<double> &window : windows)
        for (size_t i = 0; i < mean.size(); i++)
            mean[i] += window[i] / static_cast<double>(windows.size());
    return mean;
}

std::vector<double> sum_of(const std::vector<std::vector<double>> &windows, const std::vector<Part> &parts) {
    std::vector<double> sum(windows[0].size());
    for (const Part &part : parts)
        for (size_t i = 0; i < sum.size(); i++)
            sum[i] += part.share * windows[part.window][i];
    return sum;
}

double rms_of(const Buffer<double> &map_m, const Buffer<double> &amplitude) noexcept {
    double square = 0, open = 0;
    for (size_t cell = 0; cell < map_m.size(); cell++) {
        square += amplitude[cell] * map_m[cell] * map_m[cell];
        open += amplitude[cell];
    }
    return open > 0 ? std::sqrt(square / open) : 0;
}

Scene scene_at(const Problem &problem, const std::vector<double> &changes) {
    Scene scene = problem.nominal;
    for (size_t i = 0; i < problem.free.size(); i++)
        adjust(scene, problem.free[i].parameter, changes[i]);
    return scene;
}

optics::Outline outline_at(const Problem &problem, const std::vector<double> &changes, const Buffer<double> &map_m) {
    optics::Outline outline = optics::outline_of(scene_at(problem, changes), problem.settings);
    for (size_t i = 0; i < map_m.size(); i++)
        outline.pupil.opd_m[i] += map_m[i];
    return outline;
}

} // namespace toliman::calibrate
