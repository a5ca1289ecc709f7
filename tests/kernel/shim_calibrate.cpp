#include <algorithm>
#include <cmath>

#include "calibrate/planes.hpp"
#include "calibrate/prior.hpp"
#include "calibrate/solve.hpp"
#include "calibrate/start.hpp"

using namespace toliman;
using namespace toliman::calibrate;

namespace {

// Frames alternate between the windows, window w of which is w + 1 window lengths after the one before. Frame k depends
// on the values at the next start with the weight k / frames, unless its window is the last.
Problem problem_of(size_t windows, size_t frames, size_t n, const double *sigma, double smoothness) {
    Problem problem;
    for (size_t i = 0; i < n; i++)
        problem.free.push_back({{Parameter::Kind::zernike, kFirstZernike + static_cast<int>(i)}, sigma[i]});
    problem.windows.resize(windows);
    for (size_t w = 0; w < windows; w++)
        problem.windows[w].elapsed = static_cast<double>(w + 1);
    problem.frames.count = frames;
    problem.smoothness = smoothness;
    for (size_t k = 0; k < frames; k++) {
        Window &window = problem.windows[k % windows];
        window.frames.push_back(k);
        window.shares.push_back(k % windows + 1 < windows ? static_cast<double>(k) / static_cast<double>(frames) : 0);
    }
    return problem;
}

} // namespace

extern "C" {

// Given     blocks: matrices [frames][7 + n][7 + n], gradients [frames][7 + n]; values [windows][n] of the instrument
// Returned  change [windows * n + frames * 7]: of the instrument, then of the frames; covariance [windows * n]^2;
//           of the frames' parameters [frames][7][7]; 0 if there is no solution
int shim_joint_step(size_t windows, size_t frames, size_t n, const double *sigma, double smoothness,
                    const double *matrices, const double *gradients, const double *values, double damping,
                    double *change, double *covariance, double *of_frames) {
    const Problem problem = problem_of(windows, frames, n, sigma, smoothness);
    const size_t size = kOwn + n, all = windows * n;
    Linearisation normal;
    Point point;
    for (size_t k = 0; k < frames; k++) {
        Block block = {Buffer<double>(size * size), Buffer<double>(size)};
        std::copy_n(matrices + k * size * size, size * size, block.matrix.data());
        std::copy_n(gradients + k * size, size, block.gradient.data());
        normal.blocks.push_back(std::move(block));
    }
    for (size_t w = 0; w < windows; w++)
        point.instrument.emplace_back(values + w * n, values + (w + 1) * n);
    const Step step = step_from(problem, point, normal, damping);
    const Uncertainty uncertainty = uncertainty_of(problem, normal);
    if (!step.solvable || !uncertainty.solvable)
        return 0;
    for (size_t w = 0; w < windows; w++)
        std::copy(step.change.instrument[w].begin(), step.change.instrument[w].end(), change + w * n);
    for (size_t k = 0; k < frames; k++) {
        std::copy(step.change.own[k].begin(), step.change.own[k].end(), change + all + k * kOwn);
        std::copy(uncertainty.whole[k].begin(), uncertainty.whole[k].end(), of_frames + k * kOwn * kOwn);
    }
    std::copy(uncertainty.instrument.begin(), uncertainty.instrument.end(), covariance);
    return 1;
}

// Given     a scene, a parameter, and the own parameters of a frame [7]
// Returned  derivative: of its image [rows][cols] by the parameter; difference: of whole images at +- step, over 2 step
int shim_instrument_derivative(const char *json, const char *folder, const char *parameter, double step,
                               const double *own, double *derivative, double *difference) try {
    Problem problem;
    problem.settings.workers = 1;
    problem.nominal = read_scene(json, "test", folder);
    const optics::Outline outline = optics::outline_of(problem.nominal, problem.settings);
    problem.free = free_of(parameter, problem.nominal, outline.plan, 1);
    const size_t rows = problem.nominal.detector.rows, cols = problem.nominal.detector.cols;
    const Planes planes(outline, problem.parameters(), problem.capture_px);
    Buffer<double> scratch(planes.scratch_size()), image(rows * cols);
    Planes::Places places;
    planes.place(own, places, scratch.data());
    for (size_t r = 0; r < rows; r++) {
        double *const line = derivative + r * cols;
        planes.row(own, places, r, &line, scratch.data());
    }
    std::fill_n(difference, rows * cols, 0.0);
    for (const double sign : {-1.0, 1.0}) {
        const optics::Simulator simulator(outline_at(problem, {sign * step}, {}), problem.settings);
        const fit::Fit fit(simulator, {}, problem.capture_px, 1, {});
        fit::Work work = fit.model().work();
        fit.model().expect(own, {image.data(), rows, cols, cols}, work);
        for (size_t i = 0; i < rows * cols; i++)
            difference[i] += sign * image[i] / (2 * step);
    }
    return 1;
} catch (const std::exception &) {
    return 0;
}

int shim_is_antisymmetric(const char *json, const char *folder) {
    const Scene scene = read_scene(json, "test", folder);
    return is_antisymmetric(optics::make_pupil(scene, scene.telescope.pupil_samples)) ? 1 : 0;
}

int shim_is_even(int noll) {
    optics::Pupil pupil;
    pupil.samples = 32;
    pupil.amplitude = Buffer<double>(32 * 32, 1.0);
    return is_even_aberration(pupil, {Parameter::Kind::zernike, noll}) ? 1 : 0;
}
}
