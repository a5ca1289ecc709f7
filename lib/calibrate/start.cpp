// Method: each frame starts at its predicted places, or at those that a correlation with the expected frame finds,
// whichever fits better with the best fluxes and background. Places are not refined: the joint steps find them, also
// from 1 px off, and with wrong optics the best place of a star is a wrong one.
// Symmetry: a mask that steps where a sum of cosines of odd m is positive has b(-x) = 1 - b(x). With a symmetric
// aperture and without aberrations, the field in the focus is then real at every wavelength, up to a constant phase,
// and an aberration of even azimuthal order has the same image as its negative: no first-order effect, and no sign.
// Struts add an imaginary part of rms g, with (1 - o)/2 of the power, where o = |sum P(x) P(-x)|/sum |P|^2
// is the overlap of the pupil field with its mirrored conjugate. An even aberration of q rad then gives the intensity
// (g + q)^2 in addition to the real part's. With the signs of g at random over the frame, the mean squared error for a
// true q0 is (q - q0)^2 ((q + q0)^2 + 4 g^2). It has a second minimum, at q^2 + q q0 + 2 g^2 = 0, only where q0^2 > 8
// g^2, and there |q| > sqrt(2) g = sqrt(1 - o).
#include "calibrate/start.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "base/constants.hpp"
#include "base/symmetric.hpp"
#include "base/workers.hpp"
#include "calibrate/calibrate.hpp"
#include "optics/derivatives.hpp"
#include "scene/instrument.hpp"

namespace toliman::calibrate {

namespace {

// Relative change: with wrong optics a star seems fainter than it is, and an exposure of few arcs has half of the
// light.
constexpr double kLeastStartFlux = -0.75;
constexpr double kNoMap = 1e-15;   // m
constexpr double kSymmetry = 1e-3; // of the step of a mask, whose areas are known to 6e-4

using Own = std::array<double, kOwn>;

struct Found {
    Own values;
    double chi_square = std::numeric_limits<double>::infinity();
};

// With the fluxes and the background that fit best at these places: the model is linear in them.
Found with_light(const fit::Model &model, ImageView<const double> counts, const Own &values, fit::Work &work) {
    constexpr size_t kFirst = fit::flux_a, kCount = kOwn - kFirst;
    Found found = {values};
    if (!model.covers(values.data()))
        return found;
    model.linearise(&counts, values.data(), 1, work);
    double inverse[kCount * kCount];
    for (size_t i = 0; i < kCount; i++)
        for (size_t j = 0; j < kCount; j++)
            inverse[i * kCount + j] = work.matrix[(kFirst + std::min(i, j)) * kOwn + kFirst + std::max(i, j)];
    found.chi_square = work.chi_square;
    if (!invert_symmetric(inverse, kCount))
        return found;
    for (size_t i = 0; i < kCount; i++)
        for (size_t j = 0; j < kCount; j++) {
            const double change = inverse[i * kCount + j] * work.gradient[kFirst + j];
            found.values[kFirst + i] += change;
            found.chi_square -= change * work.gradient[kFirst + i];
        }
    for (const size_t flux : {fit::flux_a, fit::flux_b})
        if (!(found.values[flux] > kLeastStartFlux))
            found.chi_square = std::numeric_limits<double>::infinity(); // no star is there
    return found;
}

Own find(const fit::Fit &fit, ImageView<const double> counts, const fit::Prediction &prediction, double capture_px) {
    fit::FitWork work = fit.work();
    const fit::Fit::Start start = fit.start_of(prediction);
    Own values;
    std::copy_n(start.values, kOwn, values.begin());
    Found best = with_light(fit.model(), counts, values, work.model);
    double searched[fit::kMostParameters];
    if (fit.search(counts, start, searched, work)) {
        std::copy_n(searched, kOwn, values.begin());
        const Found other = with_light(fit.model(), counts, values, work.model);
        if (other.chi_square < best.chi_square)
            best = other;
    }
    bool within = std::isfinite(best.chi_square);
    for (size_t i = 0; i < fit::flux_a; i++)
        within &= std::fabs(best.values[i] - start.values[i]) <= capture_px;
    if (!within)
        fail(Status::argument, "the stars are not found within {options->capture_px} = %g px of their predicted places",
             capture_px);
    return best.values;
}

// The relative change from the response of `nominal`; empty if both are the same.
Buffer<double> response_change(const Detector &detector, const Detector &nominal) {
    if (detector.response == nominal.response)
        return {};
    const auto of = [](const Detector &one, size_t i) { return one.response.empty() ? 1 : one.response[i]; };
    Buffer<double> change(nominal.rows * nominal.cols);
    for (size_t i = 0; i < change.size(); i++)
        change[i] = of(detector, i) / of(nominal, i) - 1;
    return change;
}

} // namespace

uint32_t adopt_cells(const Scene &start, Scene &nominal) {
    const Telescope &from = start.telescope;
    Telescope &to = nominal.telescope;
    const uint32_t changes = (from.mask.edges != to.mask.edges ? lacks_edges : 0u) |
                             (from.pupil_samples != to.pupil_samples ? lacks_samples : 0u);
    to.mask.edges = from.mask.edges;
    to.pupil_samples = from.pupil_samples;
    return changes;
}

Point start_of(const Problem &problem, const optics::Outline &nominal, const optics::Simulator *start) {
    Point from;
    std::vector<double> changes(problem.free.size());
    from.instrument.assign(problem.windows.size(), changes);
    if (start == nullptr)
        return from;
    const Scene &scene = start->scene();
    const optics::Pupil &pupil = start->pupil(), &same = nominal.pupil;
    const bool agree = scene.detector.rows == problem.nominal.detector.rows &&
                       scene.detector.cols == problem.nominal.detector.cols &&
                       scene.stars.size() == problem.nominal.stars.size() && pupil.samples == same.samples &&
                       pupil.step_m == same.step_m && pupil.amplitude == same.amplitude &&
                       start->light().wavelength_m == nominal.light.wavelength_m;
    if (!agree)
        fail(Status::mismatch,
             "{options->start}: %s: must be %s with other values of the parameters: detector, pupil and band differ",
             scene.source.c_str(), problem.nominal.source.c_str());
    for (size_t i = 0; i < problem.free.size(); i++)
        changes[i] = change_of(scene, problem.nominal, problem.free[i].parameter);
    from.instrument.assign(problem.windows.size(), changes);
    const optics::Outline outline = outline_at(problem, changes, {});
    from.map_m.resize(outline.pupil.opd_m.size());
    for (size_t i = 0; i < from.map_m.size(); i++)
        from.map_m[i] = pupil.opd_m[i] - outline.pupil.opd_m[i];
    if (std::all_of(from.map_m.begin(), from.map_m.end(), [](double m) { return std::fabs(m) < kNoMap; }))
        from.map_m = {}; // rounding alone
    from.response = response_change(scene.detector, problem.nominal.detector);
    return from;
}

std::vector<Own> find_frames(const Problem &problem, const std::vector<double> &changes, const Buffer<double> &map_m) {
    const optics::Simulator simulator(outline_at(problem, changes, map_m), problem.settings);
    const auto fit = std::make_shared<const fit::Fit>(simulator, std::vector<Parameter>(), problem.capture_px,
                                                      simulator.plan().workers, Progress());
    std::vector<Own> found(problem.frames.count);
    run_jobs(problem.settings.workers, problem.frames.count, [&](size_t k) {
        const size_t rows = fit->rows(), cols = fit->cols();
        Buffer<double> counts(rows * cols);
        const fit::Prediction &prediction = problem.frames.predictions[k];
        in_frame(k, [&] {
            problem.frames.read(k, counts.data()); // as recorded: find() expects counts of an ideal detector
            const std::shared_ptr<const fit::Fit> of_frame = fit::of_sum(fit, prediction.spread);
            of_frame->model().undo(counts.data());
            found[k] = find(*of_frame, {counts.data(), rows, cols, cols}, prediction, problem.capture_px);
        });
    });
    return found;
}

bool is_antisymmetric(const optics::Pupil &pupil) {
    const size_t cells = pupil.samples * pupil.samples;
    double open = 0, mean = 0, square = 0;
    for (size_t i = 0; i < cells; i++) {
        const double amplitude = pupil.amplitude[i], sum = pupil.opd_m[i] + pupil.opd_m[cells - 1 - i];
        if (std::fabs(amplitude - pupil.amplitude[cells - 1 - i]) > kSymmetry)
            return false;
        open += amplitude;
        mean += amplitude * sum;
        square += amplitude * sum * sum;
    }
    mean /= open;
    const double least = kSymmetry * std::max(pupil.step_m, 1e-9);
    return square / open - mean * mean <= least * least;
}

double least_mirrored_m(const optics::Pupil &pupil, double wavelength_m) {
    const size_t cells = pupil.samples * pupil.samples;
    Buffer<double> amplitude = pupil.amplitude, opd_m = pupil.opd_m;
    optics::resolve_mixed(pupil, 1 / wavelength_m, amplitude.data(), opd_m.data());
    std::complex<double> product = 0;
    double power = 0;
    for (size_t i = 0; i < cells; i++) {
        const size_t opposite = cells - 1 - i;
        power += amplitude[i] * amplitude[i];
        product +=
            std::polar(amplitude[i] * amplitude[opposite], 2 * kPi / wavelength_m * (opd_m[i] + opd_m[opposite]));
    }
    return power > 0 ? std::sqrt(std::max(0.0, 1 - std::abs(product) / power)) * wavelength_m / (2 * kPi) : 0;
}

bool is_even_aberration(const optics::Pupil &pupil, Parameter parameter) {
    if (parameter.kind != Parameter::Kind::focus && parameter.kind != Parameter::Kind::zernike)
        return false;
    const Buffer<double> opd_m = optics::zernike_mode(pupil, parameter.number != 0 ? parameter.number : 4).opd_m;
    double product = 0;
    for (size_t i = 0; i < opd_m.size(); i++)
        product += opd_m[i] * opd_m[opd_m.size() - 1 - i];
    return product > 0;
}

} // namespace toliman::calibrate
