#include "calibrate/problem.hpp"

#include "scene/instrument.hpp"

namespace toliman::calibrate {

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
