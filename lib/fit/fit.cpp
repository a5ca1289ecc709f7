// Method: Fisher scoring. With the Fisher matrix F and the gradient g of the log likelihood at the current values
// (model.cpp), the step is F^-1 g, with the variances of the model. Where the steps end, the likelihood equations of
// Poisson counts (of Gaussian ones where read noise dominates) hold, so that the covariance is F^-1, the Cramer-Rao
// bound. In the first step variances are the mean of expected and counted ones: with the model's alone, pixels in which
// the model is far darker than the frame would have all the weight. The steps end when no place moves by 1e-6 px. From
// 0.3 px this takes 4 to 5 steps, from 0.03 px 3. In faint frames it takes up to 20, each a little shorter than the
// last: if half of its length were required of all, 4 % of the frames of 10 electrons per pixel would be lost. A fixed
// number of three leaves 3 % of frames with 0.3 px of pointing wrong by more than 5 sigma.
// Pixels beyond the limit of frame/bad_pixels.hpp are left out in rounds: those above half of the largest residual,
// then one step, until none is left and the steps end again. One cosmic ray takes three steps more.
// The stars are searched for (search.cpp) if a step is longer than kFarStep, if one of more than kLargeStep is not half
// as long as the last, if the steps diverge, or if the fit is poor: fringes repeat, and the nearest maximum of the
// likelihood may be a false one. The search, and the steps from where it ends, use the counts
// without spikes (spikes.cpp), which keep steps from ending. Separation, position angle and shift are those of the two
// places; their covariance follows from the derivatives. Reference: Kay 1993, Fundamentals of Statistical Signal
// Processing: Estimation Theory, chapter 7.
#include "fit/fit.hpp"

#include <algorithm>

#include "base/constants.hpp"
#include "base/hash.hpp"
#include "base/symmetric.hpp"
#include "fit/spikes.hpp"
#include "scene/geometry.hpp"

namespace toliman::fit {

namespace {

using Kind = Parameter::Kind;

constexpr int kMostSteps = 20;
constexpr double kStill = 1e-6;     // px
constexpr double kNear = 1e-3;      // px; shorter steps may grow while the variances change
constexpr double kLargeStep = 0.1;  // px; larger ones shrink at once where they approach the stars
constexpr double kFarStep = 0.6;    // px; beyond it steps may lead away
constexpr double kLeastFlux = -0.9; // relative change; below it the star is lost
constexpr Kind kAlways[always] = {Kind::separation, Kind::position_angle, Kind::shift_x,   Kind::shift_y,
                                  Kind::flux_a,     Kind::flux_b,         Kind::background};

// The scene's barycentre, A or B as a share of the separation from A.
double share_of(const Scene &scene, const optics::Light &light) {
    double flux[2] = {};
    for (size_t star = 0; star < 2; star++)
        for (const double photons : light.photons[star])
            flux[star] += photons;
    if (scene.binary.centre != Binary::Centre::barycentre)
        return scene.binary.centre == Binary::Centre::a ? 0 : 1;
    return flux[1] / (flux[0] + flux[1]);
}

KnownBadPixels known_bad_of(const Detector &detector) {
    return {detector.rows, detector.cols, detector.bad_pixels, detector.window};
}

std::vector<Parameter> all_of(const Scene &scene, const std::vector<Parameter> &free) {
    if (scene.stars.size() < 2)
        fail(Status::unsupported, "%s: {stars}: a fit needs two stars", scene.source.c_str());
    std::vector<Parameter> all;
    for (const Kind kind : kAlways)
        all.push_back({kind});
    for (const Parameter parameter : free) {
        const std::string name = name_of(parameter);
        if (std::find(all.begin(), all.end(), parameter) != all.end())
            fail(Status::argument, "{options->free}: \"%s\": %s", name.c_str(),
                 std::find(all.begin(), all.begin() + always, parameter) != all.begin() + always
                     ? "is always free"
                     : "must be named once");
        if (parameter.kind == Kind::roll || parameter.kind == Kind::anisotropy || parameter.kind == Kind::shear)
            fail(Status::unsupported, "{options->free}: \"%s\": moves the stars, whose places are free", name.c_str());
        if (parameter.kind == Kind::diffusion)
            fail(Status::unsupported, "{options->free}: \"%s\": blurs as jitter_xx and jitter_yy do together",
                 name.c_str());
        if (optics::Readout::has(parameter.kind))
            fail(Status::unsupported, "{options->free}: \"%s\": is the same in all frames: a calibration finds it",
                 name.c_str());
        if (all.size() == kMostParameters)
            fail(Status::argument, "{options->free}: at most %zu names", kMostParameters - always);
        all.push_back(parameter);
    }
    return all;
}

} // namespace

Fit::Fit(const optics::Simulator &simulator, const std::vector<Parameter> &free, double capture_px, unsigned workers,
         const Progress &progress)
    : scene_(simulator.scene()), known_bad_(known_bad_of(scene_.detector)), light_(simulator.light()),
      parameters_(all_of(scene_, free)), model_(simulator, free, capture_px, workers, progress),
      capture_px_(capture_px), share_a_(share_of(scene_, light_)) {
    const auto &offset = light_.offset_px;
    for (size_t axis = 0; axis < 2; axis++)
        centre_[axis] = (1 - share_a_) * offset[0][axis] + share_a_ * offset[1][axis];
    FitWork first = work();
    Result result;
    Prediction at_time_zero;
    at_time_zero.may_lack_observer = true; // sigma does not depend on its aberration
    predict(at_time_zero, first, result);
    sigma_px_ = std::sqrt(result.covariance[0]);
    digest_ = digest_of_all();
}

Fit::Fit(const Fit &first, const Fit &next, double share)
    : scene_(first.scene_), known_bad_(first.known_bad_), light_(first.light_), parameters_(first.parameters_),
      model_(first.model_, next.model_, share), capture_px_(first.capture_px_), share_a_(first.share_a_),
      sigma_px_(first.sigma_px_) {
    const auto blend = [share](double &number, double other) { number += share * (other - number); };
    const Detector &other = next.scene_.detector;
    blend(scene_.detector.pixel_scale_arcsec, other.pixel_scale_arcsec);
    blend(scene_.detector.rotation_deg, other.rotation_deg);
    blend(scene_.detector.scale_anisotropy, other.scale_anisotropy);
    blend(scene_.detector.shear, other.shear);
    blend(share_a_, next.share_a_);
    for (size_t axis = 0; axis < 2; axis++) {
        centre_[axis] = first.centre_[axis];
        blend(centre_[axis], next.centre_[axis]);
        for (size_t star = 0; star < 2; star++)
            blend(light_.offset_px[star][axis], next.light_.offset_px[star][axis]);
    }
}

Fit::Fit(const Fit &frame, const Spread &spread)
    : scene_(frame.scene_), known_bad_(frame.known_bad_), light_(frame.light_), parameters_(frame.parameters_),
      model_(frame.model_, spread), capture_px_(frame.capture_px_), share_a_(frame.share_a_),
      sigma_px_(frame.sigma_px_) {
    std::copy(std::begin(frame.centre_), std::end(frame.centre_), centre_);
}

std::shared_ptr<const Fit> of_sum(std::shared_ptr<const Fit> frame, const Spread &spread) {
    return spread.any() ? std::make_shared<const Fit>(*frame, spread) : std::move(frame);
}

FitWork Fit::work() const {
    return {model_.work(), Search(rows(), cols(), capture_px_), Buffer<double>(rows() * cols()), {}, {}, {}};
}

uint64_t Fit::digest_of_all() const {
    const Detector &detector = scene_.detector;
    const auto &offset = light_.offset_px;
    uint64_t hash = fnv1a(std::array<double, 11>{capture_px_, share_a_, centre_[0], centre_[1], offset[0][0],
                                                 offset[0][1], offset[1][0], offset[1][1], detector.rotation_deg,
                                                 detector.scale_anisotropy, detector.shear},
                          model_.digest());
    if (detector.window && !detector.bad_pixels.empty())
        hash = fnv1a(static_cast<uint64_t>(detector.window->col),
                     fnv1a(static_cast<uint64_t>(detector.window->row), hash));
    if (scene_.binary.moving) {
        const sky::Orbit &orbit = *scene_.binary.orbit;
        hash = fnv1a(std::array<double, 8>{scene_.binary.date, orbit.period_years, orbit.semi_major_arcsec,
                                           orbit.eccentricity, orbit.inclination_deg, orbit.node_deg,
                                           orbit.periastron_deg, orbit.epoch},
                     hash);
        if (scene_.binary.sky != nullptr) {                       // the places are means over the exposure
            hash = fnv1a(scene_.binary.sky->digest(false), hash); // an observer file grows with the mission
            hash = fnv1a(std::array<double, 1>{scene_.cadence.exposure_s}, hash);
            hash = fnv1a(scene_.cadence.on_target_s, hash);
        }
    }
    return hash;
}

std::array<double, 2> Fit::difference(double days) const {
    const optics::Offsets offset = optics::offsets_at(scene_, light_, days);
    return {offset[1][0] - offset[0][0], offset[1][1] - offset[0][1]};
}

std::array<double, 2> Fit::difference_on_orbit(double days) const {
    const optics::Offsets offset = optics::unobserved_offsets_at(scene_, light_, days);
    return {offset[1][0] - offset[0][0], offset[1][1] - offset[0][1]};
}

std::array<double, 2> Fit::difference_at(const Prediction &prediction) const {
    try {
        return difference(prediction.days);
    } catch (const Error &error) {
        if (!prediction.may_lack_observer || error.status() != Status::range)
            throw;
        return difference_on_orbit(prediction.days);
    }
}

Fit::Start Fit::places_of(const Prediction &prediction) const {
    std::array<double, 2> apart = difference_at(prediction);
    if (prediction.separation_px != 0) {
        const double angle = (prediction.position_angle_deg - scene_.detector.rotation_deg) * kDegree;
        const auto pixels = geometry_of(scene_.detector).to_pixels(-std::sin(angle), std::cos(angle));
        const double length = prediction.separation_px / std::hypot(pixels[0], pixels[1]);
        apart[0] = length * pixels[0];
        apart[1] = length * pixels[1];
    }
    Start start;
    start.separation_px = std::hypot(apart[0], apart[1]);
    for (size_t axis = 0; axis < 2; axis++) {
        const double centre = centre_[axis] + prediction.shift_px[axis];
        start.values[x_a + axis] = centre - share_a_ * apart[axis];
        start.values[x_b + axis] = centre + (1 - share_a_) * apart[axis];
    }
    return start;
}

Fit::Start Fit::start_of(const Prediction &prediction) const {
    const Start start = places_of(prediction);
    if (!model_.covers(start.values))
        fail(Status::argument,
             "{prediction}: stars at (%g, %g) and (%g, %g) px from the centre of the frame: outside the range of the "
             "model images, the scene's orbit over its cadence and %g px",
             start.values[x_a], start.values[y_a], start.values[x_b], start.values[y_b], capture_px_);
    return start;
}

// One step; false if it leads nowhere.
bool Fit::step(ImageView<const double> counts, double blend, double *values, FitWork &work, double &moved) const {
    const size_t n = model_.parameters();
    Work &model = work.model;
    if (!model_.covers(values))
        return false;
    model_.linearise(&counts, values, blend, model);
    if (model.used <= n || !invert_symmetric(model.matrix.data(), n))
        return false;
    moved = 0;
    for (size_t i = 0; i < n; i++) {
        double change = 0;
        for (size_t j = 0; j < n; j++)
            change += model.matrix[i * n + j] * model.gradient[j];
        if (i < flux_a)
            moved = std::fmax(moved, std::fabs(change));
        values[i] += change;
        model.chi_square -= change * model.gradient[i];
    }
    return moved <= kFarStep && values[flux_a] > kLeastFlux && values[flux_b] > kLeastFlux;
}

// blend: of the first step.
bool Fit::converge(ImageView<const double> counts, double blend, double *values, FitWork &work, Result &result) const {
    double last = kFarStep, moved;
    for (int i = 0; i < kMostSteps; i++, last = moved) {
        result.iterations++;
        if (!step(counts, i == 0 ? blend : 0, values, work, moved))
            return false;
        if (i > 0 && moved < kStill)
            return true;
        const double most = moved > kLargeStep ? 0.5 * last : std::fmax(last, kNear);
        if (i > 1 && moved > most) // diverges, or wanders far from any maximum
            return false;
    }
    return false;
}

// Fits without the bad pixels, which are found from these values on; false if there are too many, or without a maximum.
bool Fit::leave_out_bad_pixels(ImageView<const double> counts, double *values, FitWork &work, Result &result) const {
    for (bool still = false;;) {
        const BadPixels::Found found = model_.find_bad_pixels(counts, values, work.expected.data(), work.model);
        if (found == BadPixels::Found::too_many)
            return false;
        if (found == BadPixels::Found::none && (still || work.model.bad.count() == 0))
            return true;
        still = found == BadPixels::Found::none;
        double moved;
        result.iterations += still ? 0 : 1;
        if (still ? !converge(counts, 0, values, work, result) : !step(counts, 0, values, work, moved))
            return false;
    }
}

BadPixels Fit::bad_pixels_at(ImageView<const double> counts, const double *values, FitWork &work) const {
    work.model.bad.clear();
    model_.linearise(&counts, values, 0, work.model);
    if (!(work.model.excess > kBadPixelLimit))
        return {};
    double found[kMostParameters];
    std::copy_n(values, model_.parameters(), found);
    Result result;
    if (!leave_out_bad_pixels(counts, found, work, result) || work.model.bad.count() == 0)
        return {};
    report(found, work.model, result);
    return result.goodness.verdict == GoodnessVerdict::good ? work.model.bad : BadPixels();
}

// Reports a fit whose steps ended, without its bad pixels unless there are too many.
void Fit::settle(ImageView<const double> counts, double *values, FitWork &work, Result &result) const {
    report(values, work.model, result);
    if (!(work.model.excess > kBadPixelLimit))
        return;
    double found[kMostParameters];
    std::copy_n(values, kMostParameters, found);
    Result without;
    without.iterations = result.iterations;
    const bool few = leave_out_bad_pixels(counts, found, work, without);
    result.iterations = without.iterations;
    if (!few) {
        result.goodness.verdict = GoodnessVerdict::poor;
        return;
    }
    if (work.model.bad.count() == 0) // a few pixels are far off, but so are the others
        return;
    report(found, work.model, without);
    result = without;
    std::copy_n(found, kMostParameters, values);
}

// A second fit from where a search finds the stars, without spikes; better than that of `result`, if that is `still`.
bool Fit::fit_elsewhere(ImageView<const double> counts, const Start &start, bool still, double *values, FitWork &work,
                        Result &result) const {
    double found[kMostParameters];
    work.model.bad = work.known_bad;
    const bool spikes = remove_spikes(counts, model_.counts(), work.repaired);
    const ImageView<const double> clean =
        spikes ? ImageView<const double>{work.repaired.data(), rows(), cols(), cols()} : counts;
    const bool known = search(clean, start, found, work);
    bool elsewhere = !still || spikes;
    for (size_t i = x_a; i <= y_b; i++)
        elsewhere |= std::fabs(found[i] - values[i]) > kFarStep;
    Result second;
    second.iterations = result.iterations;
    bool ends = known && elsewhere && converge(clean, 0.5, found, work, second);
    if (ends && spikes) {
        ends = leave_out_bad_pixels(counts, found, work, second) && work.model.bad.count() > 0;
        if (ends)
            report(found, work.model, second);
    } else if (ends) {
        settle(counts, found, work, second);
    }
    result.iterations = second.iterations;
    if (!ends || (still && !(second.goodness.chi_square < result.goodness.chi_square)))
        return still;
    second.flags |= searched;
    result = second;
    std::copy_n(found, kMostParameters, values);
    return true;
}

bool Fit::search(ImageView<const double> counts, const Start &start, double *values, FitWork &work) const {
    const ImageView<double> expected = {work.expected.data(), rows(), cols(), cols()};
    std::copy(std::begin(start.values), std::end(start.values), values);
    model_.expect(values, expected, work.model);
    if (const std::vector<size_t> &bad = scene_.detector.bad_pixels; !bad.empty()) {
        if (counts.data != work.repaired.data()) {
            work.repaired.resize(rows() * cols());
            for (size_t r = 0; r < rows(); r++)
                std::copy_n(counts.row(r), cols(), &work.repaired[r * cols()]);
            counts = {work.repaired.data(), rows(), cols(), cols()};
        }
        for (const size_t pixel : bad)
            work.repaired[pixel] = work.expected[pixel];
    }
    const auto shift = work.search.shift(counts, {expected.data, rows(), cols(), cols()}, model_.bias());
    for (size_t i = x_a; i <= y_b; i++)
        values[i] += shift[i % 2];
    return model_.covers(values);
}

ImageView<const double> Fit::undo(ImageView<const double> counts, FitWork &work) const {
    if (!model_.has_readout())
        return counts;
    work.ideal.resize(rows() * cols());
    for (size_t r = 0; r < rows(); r++)
        std::copy_n(counts.row(r), cols(), &work.ideal[r * cols()]);
    model_.undo(work.ideal.data());
    return {work.ideal.data(), rows(), cols(), cols()};
}

void Fit::frame(ImageView<const double> counts, const Prediction &prediction, FitWork &work, Result &result) const {
    frame_of_ideal(undo(counts, work), prediction, work, result);
}

void Fit::frame_of_ideal(ImageView<const double> counts, const Prediction &prediction, FitWork &work,
                         Result &result) const {
    if (scene_.detector.response_moves_with(prediction.window))
        fail(Status::unsupported,
             "{image->windows} = [%lld, %lld]: must be detector.window of %s, %s, or its detector.response would move",
             static_cast<long long>(prediction.window->row), static_cast<long long>(prediction.window->col),
             scene_.source.c_str(), scene_.detector.window_text().c_str());
    const Start start = start_of(prediction);
    result = {};
    work.known_bad.clear();
    const bool few_known = known_bad_.add(prediction.window, work.known_bad);
    if (!few_known)
        work.known_bad.clear();
    work.model.bad = work.known_bad;
    double values[kMostParameters];
    std::copy(std::begin(start.values), std::end(start.values), values);
    bool still = converge(counts, 0.5, values, work, result);
    if (still)
        settle(counts, values, work, result);
    if (!still || result.goodness.verdict == GoodnessVerdict::poor)
        still = fit_elsewhere(counts, start, still, values, work, result);
    work.model.bad = result.bad;
    if (!few_known)
        result.goodness.verdict = GoodnessVerdict::poor;
    if (!still) {
        result.flags = not_converged;
        return;
    }
    result.displacement_px = result.values[0] - start.separation_px;
    const double half[2] = {0.5 * static_cast<double>(cols()), 0.5 * static_cast<double>(rows())};
    for (size_t i = x_a; i <= y_b; i++)
        if (std::fabs(values[i]) > half[i % 2] || std::fabs(values[i] - start.values[i]) > capture_px_)
            result.flags |= edge;
}

void Fit::expect(const Prediction &prediction, ImageView<double> counts, FitWork &work) const {
    if (!model_.has_readout())
        return model_.expect(start_of(prediction).values, counts, work.model);
    work.ideal.resize(rows() * cols());
    model_.expect(start_of(prediction).values, {work.ideal.data(), rows(), cols(), cols()}, work.model);
    model_.read(work.ideal.data());
    for (size_t r = 0; r < rows(); r++)
        std::copy_n(&work.ideal[r * cols()], cols(), counts.row(r));
}

void Fit::predict(const Prediction &prediction, FitWork &work, Result &result) const {
    const Start start = start_of(prediction);
    const size_t n = model_.parameters();
    work.model.bad.clear();
    model_.linearise(nullptr, start.values, 0, work.model);
    if (work.model.used <= n)
        fail(Status::scene, "%s: {detector}: %zu pixels of a frame do not saturate: a fit of %zu parameters needs more",
             scene_.source.c_str(), work.model.used, n);
    if (!invert_symmetric(work.model.matrix.data(), n))
        fail(Status::scene, "%s: {options->free}: a parameter is a combination of the others in a frame",
             scene_.source.c_str());
    result = {};
    report(start.values, work.model, result);
    result.flags = 0;
    result.goodness.chi_square = 1;
    result.goodness.verdict = GoodnessVerdict::good;
}

// Parameters as they are reported, from those of the model.
void Fit::describe(const double *values, const double *matrix, Result &result) const {
    const size_t n = model_.parameters();
    const double x = values[x_b] - values[x_a], y = values[y_b] - values[y_a], separation = std::hypot(x, y);
    const Geometry geometry = geometry_of(scene_.detector);
    const auto on_sky = geometry.to_angle(x, y);
    const double square = on_sky[0] * on_sky[0] + on_sky[1] * on_sky[1];
    // Rows of the derivatives of separation, position angle and shift by x and y of A and B.
    double rows[4][4] = {};
    for (size_t axis = 0; axis < 2; axis++) {
        const auto unit = geometry.to_angle(axis == 0 ? 1 : 0, axis == 0 ? 0 : 1);
        const double turn = (on_sky[0] * unit[1] - on_sky[1] * unit[0]) / square / kDegree;
        const double along = (axis == 0 ? x : y) / separation;
        rows[0][axis] = -along;
        rows[0][2 + axis] = along;
        rows[1][axis] = -turn;
        rows[1][2 + axis] = turn;
        rows[2 + axis][axis] = 1 - share_a_;
        rows[2 + axis][2 + axis] = share_a_;
    }
    const auto derivative = [&](size_t i, size_t k) { return i < 4 && k < 4 ? rows[i][k] : i == k ? 1.0 : 0.0; };
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            double sum = 0;
            for (size_t k = i < 4 ? 0 : i; k < (i < 4 ? 4 : i + 1); k++)
                for (size_t l = j < 4 ? 0 : j; l < (j < 4 ? 4 : j + 1); l++)
                    sum += derivative(i, k) * matrix[k * n + l] * derivative(j, l);
            result.covariance[i * n + j] = sum;
        }
    std::copy_n(values, n, result.state.values);
    std::copy_n(matrix, n * n, result.state.covariance);
    std::copy_n(values, n, result.values);
    result.values[0] = separation;
    result.values[1] = std::remainder(std::atan2(-on_sky[0], on_sky[1]) / kDegree + scene_.detector.rotation_deg, 360);
    for (size_t axis = 0; axis < 2; axis++)
        result.values[2 + axis] = (1 - share_a_) * values[x_a + axis] + share_a_ * values[x_b + axis] - centre_[axis];
}

// The covariance of the values is work.matrix.
void Fit::report(const double *values, const Work &work, Result &result) const {
    describe(values, work.matrix.data(), result);
    result.excluded = work.saturated;
    if (work.saturated > 0)
        result.flags |= saturated;
    const auto freedom = static_cast<double>(work.used - model_.parameters());
    result.goodness =
        frame_goodness(work.chi_square / freedom, chi_square_sigma(work.used, work.inverse_counts, freedom),
                       std::sqrt(work.largest), work.bad.count(), true);
    result.bad = work.bad;
}

} // namespace toliman::fit
