// C interface of the fit of the OPD map: a problem with exact frames, and what the modules compute for it.
#include <cmath>
#include <cstring>
#include <string>

#include "calibrate/calibrate.hpp"
#include "calibrate/map.hpp"
#include "calibrate/map_frames.hpp"
#include "calibrate/map_prior.hpp"
#include "calibrate/prior.hpp"
#include "calibrate/solve.hpp"

using namespace toliman;
using namespace toliman::calibrate;

namespace {

struct Case {
    Problem problem;
    Point truth;
    std::vector<Buffer<double>> frames;
    MapStep step;
};

// Expected photons of both stars at their places, propagated.
Buffer<double> propagated(const optics::Outline &outline, const double *own) {
    const optics::Imager imager(outline.scene, outline.pupil, outline.plan, 1);
    optics::Light light = outline.light;
    light.offset_px = {{{own[0], own[1]}, {own[2], own[3]}}};
    Buffer<double> image(outline.plan.pixels.rows * outline.plan.pixels.cols, own[fit::background]);
    for (size_t star = 0; star < 2; star++) {
        const optics::StarImages of_star = imager.images(light, star, 0, {});
        for (size_t i = 0; i < image.size(); i++)
            image[i] += (1 + own[fit::flux_a + star]) * of_star.at(0, 0)[i];
    }
    return image;
}

double separation(const std::array<double, kOwn> &own) {
    return std::hypot(own[2] - own[0], own[3] - own[1]);
}

// The modules that a product consists of, about the truth.
struct Parts {
    explicit Parts(const Case &made)
        : problem(made.problem), outline(outline_at(problem, made.truth.instrument[0], made.truth.map_m)),
          planes(outline, problem.parameters(), problem.capture_px), images(outline, planes),
          joint(made.problem, made.truth, 0), frames(problem, made.truth, joint.first().model(), planes) {}
    Problem problem;
    optics::Outline outline;
    Planes planes;
    MapImages images;
    Joint joint;
    MapFrames frames;
};

} // namespace

// own: [frames][7], true values; truth [N][N], m
extern "C" void *shim_map_make(const char *json, const char *free, size_t frames, const double *own,
                               const double *truth, unsigned workers) {
    auto made = std::make_unique<Case>();
    Problem &problem = made->problem;
    problem.settings.workers = workers;
    problem.capture_px = 2;
    const optics::Outline nominal = optics::outline_of(std::string(json), "scene", ".", problem.settings);
    problem.nominal = nominal.scene;
    problem.free = free_of(free, nominal.scene, nominal.plan, 1);
    made->truth.instrument.emplace_back(problem.free.size());
    const size_t cells = nominal.pupil.samples * nominal.pupil.samples;
    made->truth.map_m.assign(truth, truth + cells);
    Window window;
    const optics::Outline outline = outline_at(problem, made->truth.instrument[0], made->truth.map_m);
    for (size_t k = 0; k < frames; k++) {
        std::array<double, kOwn> &values = made->truth.own.emplace_back();
        std::copy_n(own + k * kOwn, kOwn, values.begin());
        made->frames.push_back(propagated(outline, values.data()));
        window.frames.push_back(k);
        problem.frames.predictions.emplace_back();
    }
    problem.windows.push_back(window);
    problem.frames.count = frames;
    problem.frames.read = [of = made.get()](size_t k, double *counts) {
        std::copy(of->frames[k].begin(), of->frames[k].end(), counts);
    };
    return made.release();
}

extern "C" void shim_map_destroy(void *made) {
    delete static_cast<Case *>(made);
}

// Photons of frame 0 with h times an OPD added to the truth, propagated.
extern "C" void shim_map_image(const void *made, size_t frame, const double *opd_m, double h, double *image) {
    const Case &of = *static_cast<const Case *>(made);
    Buffer<double> map_m = of.truth.map_m;
    for (size_t i = 0; i < map_m.size(); i++)
        map_m[i] += h * opd_m[i];
    const Buffer<double> photons =
        propagated(outline_at(of.problem, of.truth.instrument[0], map_m), of.truth.own[frame].data());
    std::copy(photons.begin(), photons.end(), image);
}

// The derivative of each frame by an OPD: images [frames][rows][cols].
extern "C" void shim_map_derivative(const void *made, const double *opd_m, double *images) {
    const Case &of = *static_cast<const Case *>(made);
    const Parts parts(of);
    const optics::Atlas &atlas = parts.planes.atlas();
    const StarSamples samples = parts.images.images_of({opd_m, opd_m + of.truth.map_m.size()});
    Buffer<double> line(atlas.cols()), scratch(atlas.scratch_size());
    for (const auto &own : of.truth.own)
        for (size_t r = 0; r < of.problem.nominal.detector.rows; r++, images += atlas.cols()) {
            std::fill_n(images, atlas.cols(), 0.0);
            for (size_t star = 0; star < 2; star++) {
                const optics::Atlas::Place place = atlas.place(star, own[2 * star], own[2 * star + 1], 1);
                atlas.row_of_samples(star, samples[star], place, r, line.data(), scratch.data());
                for (size_t x = 0; x < atlas.cols(); x++)
                    images[x] += (1 + own[fit::flux_a + star]) * line[x];
            }
        }
}

// Products of weights and samples: numbers[0] of random samples with the images of an OPD, [1] of the OPD with the
// gradient of the samples, [2] sum of the absolute values of the first.
extern "C" void shim_map_adjoint(const void *made, const double *opd_m, double (*random)(void), double *numbers) {
    const Case &of = *static_cast<const Case *>(made);
    const Parts parts(of);
    const Buffer<double> opd(opd_m, opd_m + of.truth.map_m.size());
    const StarSamples images = parts.images.images_of(opd);
    StarSamples weights = images;
    numbers[0] = numbers[1] = numbers[2] = 0;
    for (size_t star = 0; star < 2; star++)
        for (size_t i = 0; i < images[star].size(); i++) {
            weights[star][i] = random();
            numbers[0] += weights[star][i] * images[star][i];
            numbers[2] += std::fabs(weights[star][i] * images[star][i]);
        }
    const Buffer<double> gradient = parts.images.gradient_of(weights);
    for (size_t i = 0; i < opd.size(); i++)
        numbers[1] += gradient[i] * opd[i];
}

// J'W J times an OPD, into product [N][N].
extern "C" void shim_map_product(const void *made, const double *opd_m, double *product) {
    const Case &of = *static_cast<const Case *>(made);
    const Parts parts(of);
    Point none;
    none.own.resize(of.problem.frames.count);
    none.instrument.assign(1, std::vector<double>(of.problem.free.size()));
    const StarSamples images = parts.images.images_of({opd_m, opd_m + of.truth.map_m.size()});
    const Buffer<double> result = parts.images.gradient_of(parts.frames.gather(&images, none));
    std::copy(result.begin(), result.end(), product);
}

// Largest difference between the matrices of all frames and those of the accurate model, elements over the roots of
// the diagonal.
extern "C" double shim_map_matrices(const void *made) {
    const Case &of = *static_cast<const Case *>(made);
    const Parts parts(of);
    const Linearisation rough = parts.frames.matrices(), accurate = linearise(of.problem, of.truth, parts.planes, 0);
    const size_t size = kOwn + of.problem.free.size();
    double worst = 0;
    for (size_t frame = 0; frame < rough.blocks.size(); frame++)
        for (size_t i = 0; i < size; i++)
            for (size_t j = 0; j < size; j++) {
                const Buffer<double> &a = rough.blocks[frame].matrix, &b = accurate.blocks[frame].matrix;
                worst = std::max(worst, std::fabs(a[i * size + j] - b[i * size + j]) /
                                            std::sqrt(b[i * size + i] * b[j * size + j]));
            }
    return worst;
}

// Largest difference between the solutions of Solver and step_from() for random gradients, relative.
extern "C" double shim_map_solver(const void *made, double (*random)(void)) {
    const Case &of = *static_cast<const Case *>(made);
    const Parts parts(of);
    Linearisation normal = parts.frames.matrices();
    normal.excess = 1.5;
    std::vector<Buffer<double>> gradients;
    Point point = of.truth;
    for (size_t i = 0; i < of.problem.free.size(); i++)
        point.instrument[0][i] = of.problem.free[i].sigma * random();
    for (Block &block : normal.blocks) {
        const size_t size = block.gradient.size();
        for (size_t i = 0; i < size; i++)
            block.gradient[i] = std::sqrt(block.matrix[i * size + i]) * random();
        gradients.push_back(block.gradient);
    }
    const Point solved = Solver(of.problem, normal).solve(gradients, &point);
    const Step step = step_from(of.problem, point, normal, 0);
    double worst = step.solvable ? 0 : INFINITY;
    const auto compare = [&worst](const double *a, const double *b, size_t count) {
        for (size_t i = 0; i < count; i++)
            worst = std::max(worst, std::fabs(a[i] - b[i]) / std::fabs(b[i]));
    };
    compare(solved.instrument[0].data(), step.change.instrument[0].data(), of.problem.free.size());
    for (size_t frame = 0; frame < gradients.size(); frame++)
        compare(solved.own[frame].data(), step.change.own[frame].data(), kOwn);
    return worst;
}

// Errors of the separations [steps + 1][frames] (px): after a fit of the parameters without map, and after each step.
// numbers [steps][4]: chi-square per pixel before the step, iterations, residual, rms of the step (m). map_m [N][N]:
// the last one.
extern "C" void shim_map_fit(void *made, size_t steps, double *errors, double *numbers, double *map_m) {
    Case &of = *static_cast<Case *>(made);
    const size_t frames = of.problem.frames.count, n = of.problem.free.size();
    const Calibration start = calibrate::calibrate(of.problem, {{std::vector<double>(n)}, {}, {}, {}}, {});
    Point point = start.point;
    point.map_m.assign(of.truth.map_m.size(), 0.0);
    const auto note = [&](double *out) {
        for (size_t k = 0; k < frames; k++)
            out[k] = separation(point.own[k]) - separation(of.truth.own[k]);
    };
    note(errors);
    for (size_t s = 0; s < steps; s++) {
        const MapStep step = map_step(of.problem, point, {});
        for (size_t k = 0; k < frames; k++)
            for (size_t i = 0; i < kOwn; i++)
                point.own[k][i] += step.change.own[k][i];
        for (size_t i = 0; i < n; i++)
            point.instrument[0][i] += step.change.instrument[0][i];
        for (size_t i = 0; i < point.map_m.size(); i++)
            point.map_m[i] += step.change.map_m[i];
        note(errors + (s + 1) * frames);
        const double row[] = {step.chi_square / static_cast<double>(step.used), static_cast<double>(step.iterations),
                              step.residual, step.rms_m};
        std::copy_n(row, 4, numbers + 4 * s);
    }
    std::copy(point.map_m.begin(), point.map_m.end(), map_m);
}

// One step of 20 iterations from the true parameters without the map, with the frames in as many windows: map_m [N][N],
// amplitude [N][N] of the pupil, numbers [3]: chi-square per pixel before the step, iterations, residual.
extern "C" void shim_map_step(const void *made, size_t windows, double *map_m, double *amplitude, double *numbers) {
    const Case &of = *static_cast<const Case *>(made);
    Problem problem = of.problem;
    Point point = of.truth;
    point.map_m.clear();
    point.instrument.resize(windows, point.instrument[0]);
    problem.windows.assign(windows, {});
    for (size_t k = 0; k < problem.frames.count; k++)
        problem.windows[k * windows / problem.frames.count].frames.push_back(k);
    for (size_t w = 0; w + 1 < windows; w++)
        problem.windows[w].shares.assign(problem.windows[w].frames.size(), 0.25);
    MapOptions options;
    options.most_iterations = 20;
    const MapStep step = map_step(problem, point, options);
    std::copy(step.change.map_m.begin(), step.change.map_m.end(), map_m);
    const optics::Pupil pupil = outline_at(problem, point.instrument[0], {}).pupil;
    std::copy(pupil.amplitude.begin(), pupil.amplitude.end(), amplitude);
    numbers[0] = step.chi_square / static_cast<double>(step.used);
    numbers[1] = step.iterations;
    numbers[2] = step.residual;
}

// Prior and preconditioner on n x n cells, curvature of even and odd part, excess: out[0] the OPD of an unknown, [1]
// the unknown of that, [2] the preconditioned one.
extern "C" void shim_map_prior(size_t n, double rms_m, const double *unknown, const double *curvature,
                               double *const *out) {
    MapPrior prior(n, rms_m);
    const Buffer<double> given(unknown, unknown + n * n), opd_m = prior.opd_of(given);
    const Buffer<double> back = prior.unknown_of(opd_m),
                         preconditioned = prior.preconditioned(given, {curvature[0], curvature[1]}, curvature[2]);
    std::copy(opd_m.begin(), opd_m.end(), out[0]);
    std::copy(back.begin(), back.end(), out[1]);
    std::copy(preconditioned.begin(), preconditioned.end(), out[2]);
}
