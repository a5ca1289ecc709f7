// C interface of the objective of a mask design.
#include <algorithm>
#include <string>

#include "information/information.hpp"
#include "mask/objective.hpp"

using namespace toliman;

// Of a mask that covers `covered` [N][N], with the first `count` of the eight nuisances free. Returned: merit [4] =
// loss, bound, peak to mean, light in the frame; gradient [N][N].
extern "C" void shim_objective(const char *json, double step_m, int count, double peak_to_mean, double weight,
                               unsigned workers, const double *covered, double *merit, double *gradient) {
    using Kind = Parameter::Kind;
    const std::vector<Parameter> all = {{Kind::flux_a}, {Kind::flux_b}, {Kind::shift_x}, {Kind::shift_y},
                                        {Kind::roll},   {Kind::scale},  {Kind::focus},   {Kind::background}};
    const Scene scene = read_scene(json, "scene", ".");
    mask::Objective objective(scene, {all.begin(), all.begin() + count}, step_m, workers);
    const double pixels = static_cast<double>(scene.detector.rows * scene.detector.cols);
    Buffer<double> slope;
    const size_t cells = objective.samples() * objective.samples();
    const mask::Merit found =
        objective.evaluate({covered, covered + cells}, {pixels, peak_to_mean, weight, 0.05, 3 * weight},
                           gradient != nullptr ? &slope : nullptr);
    merit[0] = found.loss;
    merit[1] = found.bound_px;
    merit[2] = found.peak_to_mean;
    merit[3] = found.light_in_frame;
    if (gradient != nullptr)
        std::copy(slope.begin(), slope.end(), gradient);
}

// Bounds with all eight free of the scene's own spiral mask: of the objective, and of the simulator; and the light.
extern "C" void shim_objective_own(const char *json, double *bounds, double *light) {
    using Kind = Parameter::Kind;
    const std::vector<Parameter> all = {{Kind::flux_a}, {Kind::flux_b}, {Kind::shift_x}, {Kind::shift_y},
                                        {Kind::roll},   {Kind::scale},  {Kind::focus},   {Kind::background}};
    const optics::Simulator simulator(optics::outline_of(std::string(json), "scene", ".", {}), {});
    const optics::Pupil &pupil = simulator.pupil();
    Buffer<double> covered(pupil.opd_m.size());
    Scene clear = simulator.scene();
    clear.telescope.mask = {};
    const optics::Pupil plain = optics::make_pupil(clear, pupil.samples);
    for (size_t i = 0; i < covered.size(); i++)
        covered[i] = std::min(std::max((pupil.opd_m[i] - plain.opd_m[i]) / pupil.step_m, 0.0), 1.0);
    mask::Objective objective(simulator.scene(), all, pupil.step_m, 2);
    const mask::Score score = objective.judge(covered, 1);
    bounds[0] = score.crb_px;
    bounds[1] = information::bound_with(simulator.images(), all);
    light[0] = score.peak_to_mean; // peak over total, for one pixel
    light[1] = simulator.images().peak_photons() / simulator.images().total_photons();
}
