// Method: each frame starts at its predicted places, and at those that a correlation with the expected frame finds;
// with the optics held, damped steps of its own parameters follow, and the better result is taken. Aberrations of 100
// nm leave little of a chi-square, but places within some tenths of a pixel, from where the joint steps converge.
// Symmetry: a mask that steps where a sum of cosines of odd m is positive has b(-x) = 1 - b(x). With a symmetric
// aperture and without aberrations, the field in the focus is then real at every wavelength, up to a constant phase,
// and an aberration of even azimuthal order has the same image as its negative: no first-order effect, and no sign.
#include "calibrate/start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/workers.hpp"
#include "fit/normal_matrix.hpp"
#include "optics/derivatives.hpp"

namespace toliman::calibrate {

namespace {

constexpr int kMostSteps = 12, kMostRefused = 6; // of a frame's own parameters
constexpr double kNear = 1e-2;                   // px; shorter steps end
constexpr double kLeastFlux = -0.9;
constexpr double kSymmetry = 1e-3; // of the step of a mask, whose areas are known to 6e-4

using Own = std::array<double, kOwn>;

struct Found {
    Own values;
    double chi_square = std::numeric_limits<double>::infinity();
};

// Damped steps from `values`.
Found refined(const fit::Model &model, ImageView<const double> counts, const Own &values, fit::Work &work) {
    Found best = {values};
    if (!model.covers(values.data()))
        return best;
    model.linearise(&counts, values.data(), 1, work);
    best.chi_square = work.chi_square;
    Buffer<double> matrix = work.matrix;
    Own gradient;
    std::copy_n(work.gradient, kOwn, gradient.begin());
    double damping = 1e-2;
    for (int step = 0, refused = 0; step < kMostSteps && refused < kMostRefused; step++) {
        Buffer<double> inverse = matrix;
        for (size_t i = 0; i < kOwn; i++)
            inverse[i * kOwn + i] *= 1 + damping;
        if (!fit::invert(inverse.data(), kOwn))
            break;
        Own next = best.values;
        double moved = 0;
        for (size_t i = 0; i < kOwn; i++)
            for (size_t j = 0; j < kOwn; j++)
                next[i] += inverse[i * kOwn + j] * gradient[j];
        for (size_t i = 0; i < fit::flux_a; i++)
            moved = std::max(moved, std::fabs(next[i] - best.values[i]));
        const bool possible =
            next[fit::flux_a] > kLeastFlux && next[fit::flux_b] > kLeastFlux && model.covers(next.data());
        if (possible)
            model.linearise(&counts, next.data(), 1, work);
        if (!possible || !(work.chi_square < best.chi_square)) {
            damping *= 10;
            refused++;
            continue;
        }
        best = {next, work.chi_square};
        matrix = work.matrix;
        std::copy_n(work.gradient, kOwn, gradient.begin());
        damping /= 10;
        if (moved < kNear)
            break;
    }
    return best;
}

Own find(const fit::Fit &fit, ImageView<const double> counts, const fit::Prediction &prediction, double capture_px) {
    fit::FitWork work = fit.work();
    const fit::Fit::Start start = fit.start_of(prediction);
    Own values;
    std::copy_n(start.values, kOwn, values.begin());
    Found best = refined(fit.model(), counts, values, work.model);
    double searched[fit::kMostParameters];
    if (fit.search(counts, start, searched, work)) {
        std::copy_n(searched, kOwn, values.begin());
        const Found other = refined(fit.model(), counts, values, work.model);
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

} // namespace

std::vector<Own> find_frames(const Problem &problem, const std::vector<double> &changes, const Buffer<double> &map_m) {
    const optics::Simulator simulator(outline_at(problem, changes, map_m), problem.settings);
    const fit::Fit fit(simulator, {}, problem.capture_px, {});
    std::vector<Own> found(problem.frames.count);
    run_jobs(problem.settings.workers, problem.frames.count, [&](size_t k) {
        Buffer<double> counts(fit.rows() * fit.cols());
        in_frame(k, [&] {
            problem.frames.read(k, counts.data());
            found[k] = find(fit, {counts.data(), fit.rows(), fit.cols(), fit.cols()}, problem.frames.predictions[k],
                            problem.capture_px);
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
