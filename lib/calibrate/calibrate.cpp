// Method: all parameters q of the instrument and those of each frame maximise the likelihood of all frames together.
// Levenberg-Marquardt steps (solve.cpp) minimise
//     sum over frames and pixels of (counts - model)^2/V + sum over priors of (q/sigma)^2,
// first with the variances V of the counts, which do not change with the model, so that the sum of two points can be
// compared. Near the minimum, V is that of the model (Fisher scoring), with which the estimate has no bias at low
// counts. The derivative images (planes.cpp) are computed again only where the instrument has changed by more than 1 %
// of the width of its default prior: 1 nm, 1e-4 of scale, 0.01 deg. Far from the minimum two steps have the same: with
// derivatives wrong by a part e, of the order of the first step's length, the second one leaves e of what the first one
// left, for a fraction of the time of new ones (Traub 1964, Iterative Methods for the Solution of Equations, 8.4). The
// steps end when none is longer than 0.1 standard deviations. As they shrink quadratically, the estimate is far nearer
// to the maximum. Where the model lacks an effect, chi-square stays above 1; the steps end when it no longer decreases,
// and the verdict says so. Measured: 5 or 6 steps from 20 nm of aberrations, 7 or 8 from 100 nm.
// Bad pixels of single frames, as cosmic rays, are left out at the minimum; then the steps continue.
// Where the pupil is nearly symmetric, aberrations of even azimuthal order with the opposite sign give nearly the same
// image: a second minimum, at which the steps from 100 nm may end. A poor fit is therefore continued from there, too,
// unless its even aberrations are too small for it (start.cpp), or the frames are farther from there: at 26 second
// minima, the sum of squares was 3 to 21 times that at the point with the opposite even aberrations; at the right
// minimum of an incomplete model it is smaller.
#include "calibrate/calibrate.hpp"

#include <algorithm>
#include <cmath>

#include "base/hash.hpp"
#include "calibrate/improve.hpp"
#include "calibrate/map.hpp"
#include "calibrate/memo.hpp"
#include "calibrate/prior.hpp"
#include "calibrate/response.hpp"
#include "calibrate/start.hpp"
#include "calibrate/verdict.hpp"
#include "scene/instrument.hpp"

namespace toliman::calibrate {

namespace {

constexpr double kFirstDamping = 1e-3, kLeastDamping = 1e-9, kMostDamping = 1e6;
constexpr double kNear = 10;            // standard deviations: shorter steps continue with the variances of the model
constexpr double kGoodFit = 2;          // chi-square per pixel, below which variances are those of the model
constexpr double kStill = 0.1;          // standard deviations: shorter steps are the last
constexpr double kAtMinimum = 1;        // standard deviations: where a shorter step leads up, a poor fit is at its best
constexpr double kSameChiSquare = 1e-3; // relative change, where the model lacks an effect
constexpr double kSameMap = 1e-2;       // of the steps of the map, which take minutes
constexpr double kStale = 0.01;         // of the width of a prior: derivatives are computed again beyond it
constexpr double kFarthest = 10;        // standard deviations of its prior that a parameter may be from 0
constexpr double kLeastResponse = 0.1, kMostResponse = 3; // relative; beyond it, a pixel is a bad one
constexpr double kFarStep = 3;                            // px; a longer step of a star leads nowhere
constexpr double kLeastFitFlux = -0.9;
constexpr double kMostBend = 0.4;    // share of the charge of the brightest pixel
constexpr double kMostSpread = 0.15; // px^2, of the brightest pixel
constexpr int kMostHalvings = 3;     // of a step of the map or the response
constexpr double kEvenStart = 3;     // nm, of aberrations that have no first-order effect
constexpr double kMirrorShare = 0.7; // of the smallest rms of even aberrations at a second minimum (start.cpp)
constexpr int kMostCleanings = 3;    // rounds in which bad pixels of the frames are found
constexpr int kMirrorTrial = 4;      // iterations, after which the second minimum must be the better one

class Calibrator {
  public:
    Calibrator(const Problem &problem, const Options &options) : problem_(problem), options_(options) {
        if (problem.memo != nullptr)
            problem.memo->begin(problem, options.improved);
    }

    // Returns whether a maximum was found.
    bool run(const Point &start, Calibration &out);

  private:
    bool iterate(Calibration &out, int patience = 0);
    bool iterate_mirrored(Calibration &out, bool found);
    bool is_complete() const noexcept;
    bool leave_out_bad_pixels();
    bool iterate_response(Calibration &out);
    bool iterate_map(Calibration &out);
    void choose_sign(const std::vector<bool> &even);
    bool is_possible(const Point &trial) const;
    bool is_stale(const Point &point) const;
    void aim_planes(const Point &point);
    const Planes &planes();
    Linearisation linearised(const Point &point, double blend);
    Linearisation linearised_at(const Point &trial, double blend, bool share);
    size_t unknowns() const noexcept {
        return problem_.frames.count * kOwn + problem_.windows.size() * problem_.free.size();
    }
    double per_freedom(const Linearisation &normal) const noexcept;
    enum class Of { parameters, map, response };
    void report(Calibration &out, Of what, bool accepted, double largest) const;

    const Problem &problem_;
    const Options &options_;
    Point point_;
    Linearisation normal_;
    std::unique_ptr<Planes> planes_; // NULL until they are needed
    std::vector<double> planes_at_;
    Buffer<double> planes_map_m_;
    uint64_t planes_key_ = 0;       // hash of both
    double chi_square_to_beat_ = 0; // in a trial
};

Point moved(const Point &point, const Point &change) {
    Point next = point;
    for (size_t window = 0; window < next.instrument.size(); window++)
        for (size_t i = 0; i < next.instrument[window].size(); i++)
            next.instrument[window][i] += change.instrument[window][i];
    for (size_t frame = 0; frame < next.own.size(); frame++)
        for (size_t i = 0; i < kOwn; i++)
            next.own[frame][i] += change.own[frame][i];
    if (!change.map_m.empty())
        next.map_m.resize(change.map_m.size());
    for (size_t cell = 0; cell < change.map_m.size(); cell++)
        next.map_m[cell] += change.map_m[cell];
    if (!change.response.empty())
        next.response.resize(change.response.size());
    for (size_t pixel = 0; pixel < change.response.size(); pixel++)
        next.response[pixel] =
            std::clamp(next.response[pixel] + change.response[pixel], kLeastResponse - 1, kMostResponse - 1);
    return next;
}

void halve(Point &change) {
    for (std::vector<double> &window : change.instrument)
        for (double &value : window)
            value /= 2;
    for (auto &own : change.own)
        for (double &value : own)
            value /= 2;
    for (Buffer<double> *const image : {&change.map_m, &change.response})
        for (double &value : *image)
            value /= 2;
}

// Whether the approximations of the readout hold for the brightest pixel.
bool has_readout(const Detector &detector, double peak_e) noexcept {
    return std::fabs(detector.nonlinearity_per_e) * peak_e < kMostBend &&
           std::fabs(detector.brighter_fatter_px2_per_e) * peak_e < kMostSpread;
}

bool Calibrator::is_possible(const Point &trial) const {
    for (size_t frame = 0; frame < trial.own.size(); frame++) {
        const auto &before = point_.own[frame], &after = trial.own[frame];
        if (!(after[fit::flux_a] > kLeastFitFlux && after[fit::flux_b] > kLeastFitFlux))
            return false;
        for (size_t i = 0; i < fit::flux_a; i++)
            if (!(std::fabs(after[i] - before[i]) < kFarStep))
                return false;
    }
    for (size_t window = 0; window < trial.instrument.size(); window++)
        for (size_t i = 0; i < trial.instrument[window].size(); i++)
            if (!(std::fabs(trial.instrument[window][i]) < kFarthest * problem_.free[i].sigma))
                return false;
    return std::all_of(trial.instrument.begin(), trial.instrument.end(), [this](const auto &changes) {
        const Scene scene = scene_at(problem_, changes);
        return is_readable(scene) && has_readout(scene.detector, problem_.peak_e);
    });
}

// Whether the derivatives are too far from this point for an exact step.
bool Calibrator::is_stale(const Point &point) const {
    const std::vector<double> mean = mean_of(point.instrument);
    bool stale = planes_at_.empty();
    for (size_t i = 0; i < mean.size() && !stale; i++)
        stale =
            std::fabs(mean[i] - planes_at_[i]) > kStale * default_sigma(problem_.free[i].parameter, problem_.peak_e);
    return stale;
}

// Chooses where the derivatives are taken.
void Calibrator::aim_planes(const Point &point) {
    if (!is_stale(point))
        return;
    planes_ = nullptr; // two at once would need twice the memory
    planes_at_ = mean_of(point.instrument);
    planes_map_m_ = point.map_m;
    planes_key_ = fnv1a(planes_map_m_, fnv1a(planes_at_, kFnvOffset));
}

const Planes &Calibrator::planes() {
    if (planes_ == nullptr)
        planes_ = std::make_unique<Planes>(outline_at(problem_, planes_at_, planes_map_m_), problem_.parameters(),
                                           problem_.capture_px, problem_.frames.mean_spread(), planes_key_,
                                           problem_.settings.progress);
    return *planes_;
}

double Calibrator::per_freedom(const Linearisation &normal) const noexcept {
    return normal.chi_square / static_cast<double>(normal.used > unknowns() ? normal.used - unknowns() : 1);
}

void Calibrator::report(Calibration &out, Of what, bool accepted, double largest) const {
    out.point = point_;
    out.goodness.chi_square = per_freedom(normal_);
    if (options_.on_step)
        options_.on_step(out, {what == Of::map, what == Of::response, accepted,
                               problem_.memo != nullptr && problem_.memo->recalled(),
                               out.iterations + out.map_iterations + out.response_iterations, out.goodness.chi_square,
                               largest, options_.lack});
}

bool Calibrator::is_complete() const noexcept {
    const double sigma = chi_square_sigma(normal_.used, 0, static_cast<double>(normal_.used));
    return per_freedom(normal_) < chi_square_quantile(sigma, kFrameSigmas);
}

Linearisation lost() {
    Linearisation nothing;
    nothing.lost = true;
    return nothing;
}

Linearisation Calibrator::linearised(const Point &point, double blend) {
    return recalled<Linearisation>(problem_.memo, {hash_of(point), bits_of(blend), planes_key_},
                                   [&] { return linearise(problem_, point, planes(), blend); });
}

// share: with the present derivatives. A scene far from the minimum may be refused, as with a scale at which the frame
// shows aliases: lost.
Linearisation Calibrator::linearised_at(const Point &trial, double blend, bool share) {
    if (!share)
        aim_planes(trial);
    Linearisation normal = recalled<Linearisation>(problem_.memo, {hash_of(trial), bits_of(blend), planes_key_}, [&] {
        try {
            return linearise(problem_, trial, planes(), blend);
        } catch (const Error &error) {
            if (error.status() != Status::scene)
                throw;
            Linearisation refused = lost();
            refused.refused = true;
            return refused;
        }
    });
    if (normal.refused && !share) {
        planes_at_.clear();
        aim_planes(point_);
    }
    return normal;
}

// patience: iterations after which chi-square must be below that to beat; 0: any number.
bool Calibrator::iterate(Calibration &out, int patience) {
    double damping = kFirstDamping, blend = 1;
    const int first = out.iterations;
    aim_planes(point_);
    normal_ = linearised(point_, blend);
    bool shared = false;              // normal_ has the derivatives of the step before
    uint64_t made_with = planes_key_; // normal_
    if (!normal_.lost && normal_.used <= unknowns())
        fail(Status::argument,
             "{count} = %zu: frames of %zu pixels that do not saturate: must be more than %zu unknowns",
             problem_.frames.count, normal_.used, unknowns());
    while (out.iterations < options_.most_iterations && !normal_.lost) {
        out.iterations++;
        const double damped = blend > 0 ? damping : 0;
        const Step step = recalled<Step>(
            problem_.memo, {hash_of(point_), bits_of(damped), bits_of(blend), bits_of(normal_.chi_square), made_with},
            [&] { return step_from(problem_, point_, normal_, damped); });
        const Point trial = step.solvable ? moved(point_, step.change) : point_;
        const bool near = step.solvable && step.largest < kNear && normal_.excess < kGoodFit;
        const double next_blend = near ? 0 : blend;
        const bool share =
            !near && blend > 0 && patience == 0 && !shared && made_with == planes_key_ && is_stale(trial);
        Linearisation next = step.solvable && is_possible(trial) ? linearised_at(trial, next_blend, share) : lost();
        const double before = per_freedom(normal_);
        const bool better = next.chi_square / normal_.excess + prior_cost(problem_, trial) <
                            normal_.chi_square / normal_.excess + prior_cost(problem_, point_);
        const bool accepted = !next.lost && (next_blend == 0 || better);
        if (accepted) {
            point_ = trial;
            normal_ = std::move(next);
            damping = std::max(damping / 10, kLeastDamping);
            shared = share;
            made_with = planes_key_;
        } else if (!shared) {
            damping *= 10;
        }
        report(out, Of::parameters, accepted, step.largest);
        if (!accepted && shared) { // the derivatives may be to blame
            aim_planes(point_);
            normal_ = linearised(point_, blend);
            made_with = planes_key_;
            shared = false;
            continue;
        }
        if (!accepted && step.solvable && step.largest < kAtMinimum && normal_.excess > kGoodFit) {
            normal_ = linearised(point_, 0);
            return !normal_.lost;
        }
        if (!accepted && (blend == 0 || damping > kMostDamping))
            return false;
        const double after = per_freedom(normal_);
        const bool complete = is_complete();
        if (patience > 0 && out.iterations - first >= patience && after > chi_square_to_beat_)
            return false;
        if (accepted && blend == 0 &&
            (step.largest < kStill || (!complete && std::fabs(after - before) < kSameChiSquare * before)))
            return true;
        if (accepted && blend > 0 && !shared && !complete && before - after < kSameChiSquare * before)
            blend = 0;
        if (accepted)
            blend = std::min(blend, next_blend);
    }
    return false;
}

// Continues a poor fit with the opposite even aberrations; keeps the better of both. Returns whether that is a minimum;
// found: whether the present one is.
bool Calibrator::iterate_mirrored(Calibration &out, bool found) {
    Scene flat = problem_.nominal;
    flat.telescope.zernikes.clear();
    const optics::Outline outline = optics::outline_of(flat, problem_.settings);
    const optics::Pupil &pupil = outline.pupil;
    const std::vector<double> &wavelengths = outline.light.wavelength_m;
    const double least_nm = kMirrorShare * 1e9 * least_mirrored_m(pupil, wavelengths[wavelengths.size() / 2]);
    Point mirrored = point_;
    double squares = 0;
    for (size_t i = 0; i < problem_.free.size(); i++) {
        const Parameter parameter = problem_.free[i].parameter;
        if (!is_even_aberration(pupil, parameter))
            continue;
        const double nominal = change_of(problem_.nominal, flat, parameter);
        for (std::vector<double> &window : mirrored.instrument) {
            squares += (nominal + window[i]) * (nominal + window[i]);
            window[i] = -window[i] - 2 * nominal;
        }
    }
    if (squares < least_nm * least_nm * static_cast<double>(mirrored.instrument.size()))
        return found;
    const Linearisation there = linearised(mirrored, 0);
    if (there.lost || there.chi_square > normal_.chi_square)
        return found;
    const Point before = point_;
    chi_square_to_beat_ = per_freedom(normal_);
    point_ = mirrored;
    if (iterate(out, kMirrorTrial) && per_freedom(normal_) < chi_square_to_beat_)
        return true;
    point_ = before;
    aim_planes(point_);
    normal_ = linearised(point_, 0);
    return found && !normal_.lost;
}

// Finds the bad pixels of the frames at the present point: whether they are others than before. The rule is that of a
// fit (frame/bad_pixels.hpp); where a frame is poor without them, the model is wrong and none is left out.
bool Calibrator::leave_out_bad_pixels() {
    std::vector<BadPixels> bad = recalled<std::vector<BadPixels>>(problem_.memo, {hash_of(point_)},
                                                                  [&] { return find_bad_pixels(problem_, point_); });
    const bool same = std::equal(
        bad.begin(), bad.end(), point_.bad.begin(), point_.bad.end(), [](const BadPixels &a, const BadPixels &b) {
            return a.count() == b.count() && std::all_of(a.begin(), a.end(), [&b](size_t one) { return b.has(one); });
        });
    if (!same)
        point_.bad = std::move(bad);
    return !same;
}

// Gauss-Newton steps of the response together with all other parameters; shorter ones where a whole one leads up, and
// none where all do: the model is then incomplete.
bool Calibrator::iterate_response(Calibration &out) {
    ResponseOptions how;
    how.rms = out.response_rms = options_.response_rms;
    Linearisation found; // about the response
    Point best, change;  // of the smallest chi-square so far, and the step from there
    double least = std::numeric_limits<double>::infinity();
    int halved = 0;
    for (bool rests = false; !rests;) {
        if (out.response_iterations == options_.most_iterations)
            return false;
        out.response_iterations++;
        ResponseStep step = recalled<ResponseStep>(problem_.memo, {hash_of(point_), bits_of(how.rms)},
                                                   [&] { return response_step(problem_, point_, how); });
        const bool leads_up = step.lost || step.chi_square > (1 + kSameChiSquare) * least;
        if (!leads_up) {
            if (!step.solvable)
                return false;
            best = point_;
            change = std::move(step.change);
            least = normal_.chi_square = step.chi_square;
            normal_.used = step.used;
            out.response_sigma = std::move(step.sigma);
            found.of_response = std::move(step.covariance);
            found.separation_sigma_px = step.separation_sigma_px;
            halved = 0;
        } else if (best.own.empty()) {
            return false;
        } else if (halved++ < kMostHalvings) {
            halve(change);
        } else {
            change = {};
        }
        const Point trial = change.own.empty() ? best : moved(best, change);
        if (!is_possible(trial))
            return false;
        point_ = trial;
        rests = change.own.empty() || (!leads_up && step.largest < kStill);
        report(out, Of::response, !leads_up, step.largest);
    }
    out.response_parameters = out.response_sigma.empty() ? 0 : response_parameters(out.response_sigma, how.rms);
    aim_planes(point_);
    normal_ = linearised(point_, 0);
    normal_.of_response = std::move(found.of_response);
    normal_.separation_sigma_px = found.separation_sigma_px;
    return !normal_.lost;
}

// Gauss-Newton steps of the map, as long as chi-square decreases; shorter ones where a whole one leads up.
bool Calibrator::iterate_map(Calibration &out) {
    bool falls = true;
    while (falls && out.map_iterations < options_.most_iterations) {
        out.map_iterations++;
        MapOptions how;
        how.rms_m = options_.map_rms_m;
        MapStep step = recalled<MapStep>(problem_.memo, {hash_of(point_), bits_of(how.rms_m)},
                                         [&] { return map_step(problem_, point_, how); });
        if (step.lost || !step.solvable)
            return false;
        const double before = per_freedom(normal_);
        bool accepted = false;
        for (int halved = 0; !accepted && halved <= kMostHalvings; halved++, halve(step.change)) {
            const Point trial = moved(point_, step.change);
            Linearisation next = linearised(trial, 0);
            accepted = !next.lost && per_freedom(next) < before;
            if (accepted) {
                point_ = trial;
                normal_ = std::move(next);
            }
        }
        out.map_rms_m = rms_of(point_.map_m, out.amplitude);
        report(out, Of::map, accepted, 1e9 * step.rms_m);
        falls = accepted && before - per_freedom(normal_) >= kSameMap * std::max(1.0, before);
    }
    planes_at_.clear(); // those with the map
    aim_planes(point_);
    normal_ = linearised(point_, 0);
    return !falls && !normal_.lost;
}

// Without a sign, that of the first even aberration is positive. The residuals remain as they are.
void Calibrator::choose_sign(const std::vector<bool> &even) {
    const size_t first = static_cast<size_t>(std::find(even.begin(), even.end(), true) - even.begin()), n = even.size();
    if (first == n || mean_of(point_.instrument)[first] >= 0)
        return;
    for (std::vector<double> &window : point_.instrument)
        for (size_t i = 0; i < n; i++)
            window[i] *= even[i] ? -1 : 1;
    for (Block &block : normal_.blocks)
        for (size_t i = 0; i < n; i++) {
            if (!even[i])
                continue;
            const size_t size = kOwn + n, at = kOwn + i;
            block.gradient[at] *= -1;
            for (size_t j = 0; j < size; j++) {
                block.matrix[at * size + j] *= -1;
                block.matrix[j * size + at] *= -1;
            }
        }
}

bool Calibrator::run(const Point &start, Calibration &out) {
    point_ = start;
    if (point_.own.empty())
        point_.own = recalled<OwnOfFrames>(problem_.memo, {hash_of(start)},
                                           [&] { return find_frames(problem_, start.instrument[0], start.map_m); });
    out.before =
        recalled<Buffer<double>>(problem_.memo, {hash_of(point_)}, [&] { return whitened_frame(problem_, point_, 0); });
    bool found = iterate(out);
    if (!normal_.lost && !is_complete())
        found = iterate_mirrored(out, found);
    for (int round = 0; round < kMostCleanings && found && !normal_.lost && leave_out_bad_pixels(); round++)
        found = iterate(out);
    if (normal_.lost || (!found && !options_.response)) // without the response, steps may lead up
        return false;
    choose_sign(out.even);
    for (int round = 0; options_.response && (round == 0 || (round < kMostCleanings && leave_out_bad_pixels()));
         round++)
        if (!iterate_response(out))
            return false;
    if (options_.map && !iterate_map(out))
        return false;
    if (!point_.map_m.empty() && options_.map)
        out.map_parameters = recalled<double>(problem_.memo, {hash_of(point_), bits_of(options_.map_rms_m)},
                                              [&] { return map_parameters(problem_, point_, options_.map_rms_m); });
    judge(problem_, point_, normal_, out);
    return true;
}

} // namespace

Calibration calibrate(const Problem &problem, const Point &start, const Options &options) {
    Calibration out;
    out.nominal = problem.nominal;
    out.free = problem.free;
    for (const Window &window : problem.windows) {
        out.first_days.push_back(window.first_days);
        out.windows.push_back(window.frames);
    }
    const optics::Outline nominal = optics::outline_of(problem.nominal, problem.settings);
    out.samples = nominal.pupil.samples;
    out.nominal_map_m = optics::opd_of_file(problem.nominal, out.samples);
    out.amplitude = nominal.pupil.amplitude;
    out.left_out = problem.left_out;
    out.improved = options.improved;
    out.pupil_error = nominal.plan.pupil_error;
    out.peak_noise =
        1 / std::sqrt(std::max(1.0, problem.peak_photons * problem.nominal.detector.qe) * problem.frames.exposures());
    const bool antisymmetric = is_antisymmetric(nominal.pupil);
    Point first = start;
    for (size_t i = 0; i < problem.free.size(); i++) {
        out.even.push_back(antisymmetric && is_even_aberration(nominal.pupil, problem.free[i].parameter));
        for (std::vector<double> &window : first.instrument)
            if (out.even[i] && window[i] == 0)
                window[i] = kEvenStart;
    }
    out.underway = true;
    Calibrator calibrator(problem, options);
    if (!calibrator.run(first, out))
        out.flags = not_converged;
    out.underway = false;
    out.lacks = lacks_of(out, problem, options);
    return out;
}

Scene fitted_scene(const Calibration &calibration, size_t window) {
    Problem problem;
    problem.nominal = calibration.nominal;
    problem.free = calibration.free;
    return scene_at(problem, calibration.point.instrument[window]);
}

std::vector<double> fitted_response(const Calibration &calibration) {
    Detector detector = calibration.nominal.detector;
    if (!calibration.point.response.empty())
        change_response(calibration.point.response, detector);
    return detector.response;
}

Buffer<double> opd_change(const Calibration &calibration, size_t window) {
    optics::Pupil pupil;
    pupil.samples = calibration.samples;
    pupil.amplitude = calibration.amplitude;
    pupil.opd_m = Buffer<double>(calibration.samples * calibration.samples);
    Buffer<double> change(pupil.opd_m.size());
    for (size_t i = 0; i < calibration.free.size(); i++) {
        const Parameter parameter = calibration.free[i].parameter;
        if (parameter.kind != Parameter::Kind::focus && parameter.kind != Parameter::Kind::zernike)
            continue;
        const Buffer<double> mode = optics::zernike_mode(pupil, parameter.number != 0 ? parameter.number : 4).opd_m;
        for (size_t cell = 0; cell < change.size(); cell++)
            change[cell] += calibration.point.instrument[window][i] * mode[cell];
    }
    for (size_t cell = 0; cell < calibration.point.map_m.size(); cell++)
        change[cell] += calibration.amplitude[cell] > 0 ? calibration.point.map_m[cell] : 0;
    return change;
}

} // namespace toliman::calibrate
