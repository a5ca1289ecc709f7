// Method: each candidate is searched in the series without the planets before it, with the derivatives of their signals
// among the nuisance functions. A candidate whose Bayes factor reaches the threshold joins the planets, which are then
// fitted together, and the posterior of each is computed again with all others: where it leads to a better joint fit,
// as the orbit of a planet was distorted by one that was not known yet, all is repeated.
//
// Rejected: removing the harmonics of a strong signal, which leaves 0.6 uas of an eccentric giant of 340 uas after
// eight.
#include "planet/search.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "planet/instruments.hpp"

namespace toliman::planet {

namespace {

constexpr double kLeastScale = 0.05e-6, kMostScale = 100e-6; // arcsec
constexpr double kLeastGain = 0.1;                           // of the sum of squares, by another start of the joint fit
constexpr double kMostSpread = 1.2;                          // of the residuals, if measurements are readmitted
constexpr double kLeastLeft = 0.01;                          // of the sum of squares, by a strong planet
constexpr double kEccentric = 0.5, kLongerMargin = 10;       // of the sum of squares, by an orbit of a longer period
constexpr double kMostWidths = 5;   // from the median frequency of the posterior to that of the joint fit
constexpr double kMostChange = 0.2; // of the logarithm of a scale of the jitter
constexpr int kMostTimes = 8;
constexpr int kMostTurns = 4, kMostRounds = 4;

// Weighted rms about the nuisance functions.
double size_of(const Series &series) {
    const std::vector<FittedPlanet> none;
    const JointFunctions functions(series, none, 0);
    const Design design(series, functions.all(), series.y, unit_jitter(series));
    if (const size_t function = design.dependent(); function < series.functions.size())
        fail(Status::argument, "{series}: %s is a combination of the functions before it",
             series.functions[function].name.c_str());
    return rms_of(series, design);
}

// Range of the scales of amplitudes in a series of this rms: from a tenth of the standard error of an amplitude whose
// noise is the rms. It does not depend on the sigmas, which may be too small.
constexpr double kLeastOfError = 0.1, kMostOfRms = 3;
double least_scale(const Series &series, double rms) noexcept {
    return kLeastOfError * rms * std::sqrt(2 / static_cast<double>(series.used));
}

// Replaces the defaults of the periods.
void set_periods(Settings &settings) {
    const Units &units = settings.units;
    settings.period_min = settings.period_min > 0 ? settings.period_min : 60 / units.days;
    settings.period_max = settings.period_max > 0 ? settings.period_max : 1000 / units.days;
    if (!(settings.period_min < settings.period_max))
        fail(Status::argument, "{options->prior.period_min} = %.9g: must be below period_max = %.9g",
             settings.period_min, settings.period_max);
}

// Replaces the defaults.
Settings settled(const Series &series, Settings settings) {
    const double rms = settings.rms = size_of(series);
    if (series.median_sigma == 0 && !(rms > 0))
        fail(Status::argument, "{series}: the functions describe all values: no jitter can be fitted");
    set_periods(settings);
    const Units &units = settings.units;
    if (settings.amplitude_max == 0) {
        const bool is_known = units.unit > 0 && !units.velocity;
        settings.scales_of_rms = !is_known && rms > 0;
        settings.amplitude_min = is_known ? kLeastScale / units.unit : least_scale(series, rms);
        settings.amplitude_max = is_known ? std::max(kMostScale / units.unit, kMostOfRms * rms)
                                          : kMostOfRms * std::max(rms, spread_of(series, series.y));
    }
    if (!(settings.amplitude_min > 0 && settings.amplitude_min < settings.amplitude_max))
        fail(Status::argument, "{options->prior.amplitude_min} = %g: must be above 0 and below amplitude_max = %g",
             settings.amplitude_min, settings.amplitude_max);
    if (settings.jitter && settings.jitter_max == 0)
        settings.jitter_max = rms;
    if (!(settings.jitter_max > 0)) // the functions describe all values
        settings.jitter = false;
    return settings;
}

Prior prior_of(const Series &series, const Settings &settings) {
    Prior prior = {1 / settings.period_max, 1 / settings.period_min, settings.eccentricity_max,
                   scales_between(settings.amplitude_min, settings.amplitude_max)};
    if (settings.jitter) {
        prior.jitter_max = settings.jitter_max;
        prior.jitter_knee = series.median_sigma > 0 ? series.median_sigma / 10 : settings.jitter_max / 1000;
    }
    return prior;
}

// The scale of the prior of a planet's amplitudes: their rms.
double scale_of(const Series &series, const Planet &planet) noexcept {
    double square = 0;
    for (const double amplitude : planet.amplitudes)
        square += amplitude * amplitude;
    return std::sqrt(square / static_cast<double>(series.amplitudes()));
}

class Searcher {
  public:
    // The scales of the jitter of the series become those of the last fit.
    Searcher(Series &series, const Prior &prior, const Settings &settings)
        : series_(series), prior_(prior), settings_(settings) {}

    // Searches, and fills the result. A trial ends, and returns false, when the fit is poor and no strong planet is the
    // reason why further ones are to be searched: the sigmas are too small, or the model is wrong.
    bool run(bool is_trial, Result &result) {
        while (planets_.size() < settings_.most) {
            const Noise before = noise();
            Candidate next = examine(planets_.size(), "planet " + std::to_string(planets_.size() + 1));
            if (next.log10_bayes < settings_.threshold) {
                set_rejected(std::move(next));
                if (!planets_.empty())
                    set_noise(before);
                break;
            }
            planets_.push_back(next.fitted);
            candidates_.push_back(std::move(next));
            fit_all(planets_);
            if (is_trial && is_hopeless())
                return false;
            settle_together();
            if (rejected_ || has_reason(candidates_.back()))
                break;
        }
        for (size_t p = 0; p < planets_.size(); p++)
            candidates_[p].fitted = planets_[p];
        if (rejected_)
            candidates_.push_back(std::move(*rejected_));
        for (size_t c = 0; c < candidates_.size(); c++)
            describe_best(c, candidates_[c]);
        result.candidates = std::move(candidates_);
        keep_fit(result);
        return !is_trial || !is_poor(*result.design);
    }

    // The measurements that do not belong, with the residuals of the fit. One that was left out is readmitted if the
    // same planets describe it, in a fit of all measurements.
    std::vector<bool> far(const Result &result) const {
        std::vector<bool> marked = far_residuals(series_, result.residuals);
        if (series_.used == series_.n || planets_.empty())
            return marked;
        Series all = series_;
        all.leave_out(std::vector<bool>(all.n));
        std::vector<FittedPlanet> planets = planets_;
        fit_jointly(all, jitter_, settings_.eccentricity_max, planets);
        const Buffer<double> together = residuals_of_fit(all, planets);
        if (scale_of(all, together) > kMostSpread * scale_of(all, result.residuals))
            return marked; // a fit that follows an outlier leaves the others
        const std::vector<bool> unexplained = far_residuals(all, together);
        for (size_t i = 0; i < all.n; i++)
            marked[i] = marked[i] && (unexplained[i] || series_.factor[i] > 0);
        return marked;
    }

  private:
    // The jitter of the last posterior, and its scales.
    struct Noise {
        double jitter;
        std::vector<double> scales;
    };
    Noise noise() const { return {jitter_, series_.jitter_scales()}; }
    void set_noise(const Noise &noise) {
        jitter_ = noise.jitter;
        series_.set_jitter_scales(noise.scales);
    }

    // Whether all measurements, or those of an instrument, fit poorly.
    bool is_poor(const Design &design) const {
        const auto is_bad = [](const Goodness &one) { return one.verdict == GoodnessVerdict::poor; };
        const std::vector<Goodness> each = goodness_of_groups(series_, design, true);
        return is_bad(goodness_with_jitter(series_, design)) ||
               (each.size() > 1 && std::any_of(each.begin(), each.end(), is_bad));
    }

    bool is_hopeless() const {
        std::vector<FittedPlanet> before = planets_;
        before.pop_back();
        const Design with = design_of(planets_), without = design_of(before);
        return is_poor(with) && with.square() > kLeastLeft * without.square();
    }

    // What functions and planets leave.
    Design design_of(const std::vector<FittedPlanet> &planets) const {
        const JointFunctions functions(series_, planets, planets.size());
        return {series_, functions.all(), without_planets(series_, planets, planets.size()), jitter_};
    }

    // Whether the last candidate of the joint fit has a reason against a planet of its own: the search ends with it.
    bool has_reason(Candidate candidate) const {
        candidate.fitted = planets_.back();
        describe_best(planets_.size() - 1, candidate);
        return candidate.reasons != 0;
    }

    // [n]
    Buffer<double> residuals_of_fit(const Series &series, const std::vector<FittedPlanet> &planets) const {
        const JointFunctions functions(series, planets, planets.size());
        const Buffer<double> values = without_planets(series, planets, planets.size());
        return residuals_of(series, functions.all(), values, Design(series, functions.all(), values, jitter_));
    }

    // The square that a joint fit leaves which begins at this orbit.
    double fit_with(const Orbit &orbit, size_t which, FittedPlanet &fitted) const {
        std::vector<FittedPlanet> together = others_of(which);
        together.push_back({{orbit, fitted.planet.amplitudes}, fitted.scale});
        const double square = fit_all(together);
        fitted = together.back();
        return square;
    }

    // The orbit of a joint fit that the lattice has missed, as it is in the prior and outside the posterior. The fit
    // begins at the best node; of a likely planet at the peaks of the first nodes; and of an eccentric orbit at two to
    // eight times its period: an orbit with a short passage through periastron, which the first cells do not resolve,
    // fits a few of its passages at a part of its period, or with a jitter that excuses the others.
    std::optional<FittedPlanet> missed_orbit(size_t which, const Lattice &lattice, const Candidate &candidate) const {
        const Orbit &best = candidate.fitted.planet.orbit;
        FittedPlanet fitted = candidate.fitted;
        double least = fit_with(best, which, fitted) - kLongerMargin;
        const auto is_better = [&](const Orbit &start) {
            FittedPlanet there = candidate.fitted;
            const double square = is_in_prior(start) ? fit_with(start, which, there) : HUGE_VAL;
            if (!(square < least))
                return false;
            least = square;
            fitted = there;
            return true;
        };
        if (candidate.log10_bayes > 0)
            for (const Orbit &peak : lattice.peaks())
                is_better(peak);
        bool is_longer = false;
        for (int times = 2; best.eccentricity > kEccentric && times <= kMostTimes; times++)
            for (int passage = 0; passage < times; passage++) // as long
                is_longer = is_better({best.frequency / times, 1 - (1 - best.eccentricity) / std::pow(times, 2.0 / 3),
                                       (best.anomaly + passage) / times, best.star}) ||
                            is_longer;
        const bool is_missed = is_longer || is_outside(candidate.samples, fitted.planet.orbit);
        return is_missed && is_in_prior(fitted.planet.orbit) ? std::optional(fitted) : std::nullopt;
    }

    bool is_in_prior(const Orbit &orbit) const noexcept {
        return orbit.frequency > prior_.frequency_min && orbit.frequency < prior_.frequency_max &&
               orbit.eccentricity <= prior_.eccentricity_max;
    }

    static bool is_outside(const std::vector<PosteriorSample> &samples, const Orbit &orbit) {
        std::vector<double> frequencies;
        frequencies.reserve(samples.size());
        for (const PosteriorSample &sample : samples)
            frequencies.push_back(sample.planet.orbit.frequency);
        const Interval known = interval_of(std::move(frequencies));
        return std::fabs(orbit.frequency - known[1]) > kMostWidths * (known[2] - known[0]) / 2;
    }

    // The posterior of planet `which`, or of one more, with the other planets. Velocities tell the star of a planet:
    // both stars have the same share of the prior.
    Candidate examine(size_t which, const std::string &stage) {
        const JointFunctions functions(series_, planets_, which);
        const Buffer<double> values = without_planets(series_, planets_, which);
        Prior prior = prior_;
        const std::vector<double> jitters =
            has_scales() ? jitters_of(series_, functions.all(), values) : std::vector<double>();
        if (settings_.scales_of_rms) {
            const double rms = rms_of(series_, Design(series_, functions.all(), values, unit_jitter(series_)));
            if (rms > 0)
                prior.scales = scales_between(
                    least_scale(series_,
                                has_scales() ? std::min(rms, quiet_rms(functions.all(), values, jitters)) : rms),
                    kMostOfRms * std::max(rms, spread_of(series_, values)));
        }
        if (has_scales())
            series_.set_jitter_scales(jitter_scales_of(series_, functions.all(), values, jitters, settings_.rms));
        if (!series_.has_velocities())
            return examine_star({series_, prior, functions.all(), values, 0}, which, stage);
        const Noise before = noise();
        Candidate of_a = examine_star({series_, prior, functions.all(), values, 0}, which, stage + " of A");
        const Noise noise_of_a = noise();
        set_noise(before);
        Candidate of_b = examine_star({series_, prior, functions.all(), values, 1}, which, stage + " of B");
        const double difference = of_a.log10_bayes - of_b.log10_bayes;
        if (difference >= 0)
            set_noise(noise_of_a);
        Candidate &likelier = difference >= 0 ? of_a : of_b;
        likelier.log10_star = difference;
        likelier.log10_bayes += std::log10((1 + std::pow(10, -std::fabs(difference))) / 2);
        return std::move(likelier);
    }

    // Weighted rms with the jitter of each instrument: the quiet ones determine an amplitude.
    double quiet_rms(const std::vector<const Function *> &functions, const Buffer<double> &values,
                     const std::vector<double> &jitters) const {
        Series own = series_;
        own.set_jitter_scales(jitters);
        return rms_of(own, Design(own, functions, values, 1));
    }

    bool has_scales() const noexcept { return settings_.jitter && series_.groups.size() > 1; }

    // The scales of the jitters of instruments are those without a planet, and where they lead to larger odds, those
    // with one.
    Candidate examine_star(const Problem &problem, size_t which, const std::string &stage) {
        const std::vector<Box> boxes = whole_boxes(problem);
        Candidate candidate = {};
        double log_null = 0, jitter = 0;
        {
            const JitterGrid without(problem);
            const Design &design = without.design(without.null().best);
            log_null = without.null().log_sum;
            jitter = without.jitter(without.null().best);
            candidate.log10_fap = Detection(problem, design, settings_.fap).log10_fap();
        }
        Candidate with_scales = candidate;
        examine_orbits(problem, boxes, which, stage, log_null, candidate);
        if (!has_scales())
            return candidate;
        const Noise before = noise();
        with_scales.fitted = scout(problem, boxes, jitter, stage);
        jitter_ = jitter;
        for (int turn = 0; turn < kMostTurns && adapt_scales(which, with_scales); turn++)
            examine_orbits(problem, boxes, which, stage, log_null, with_scales);
        if (!with_scales.samples.empty() && with_scales.log10_bayes >= candidate.log10_bayes)
            return with_scales;
        set_noise(before);
        return candidate;
    }

    // The most probable planet with the jitters of a series without it.
    FittedPlanet scout(const Problem &problem, const std::vector<Box> &boxes, double jitter,
                       const std::string &stage) const {
        Series quiet = series_;
        for (size_t i = 0; i < quiet.n; i++)
            quiet.sigma[i] = std::hypot(quiet.sigma[i], jitter * quiet.jitter_scale(i));
        Prior prior = problem.prior;
        prior.jitter_max = 0;
        const Problem easier = {quiet, prior, problem.functions, problem.values, problem.star};
        const Lattice lattice(easier, boxes, settings_.threads, settings_.progress, (stage + ", jitters").c_str());
        const Planet best = best_of(easier, lattice);
        return {best, std::max(scale_of(series_, best), prior.scales.front())};
    }

    // Sets the scales of the jitter to those with this planet; false if they were near them.
    bool adapt_scales(size_t which, const Candidate &candidate) {
        std::vector<FittedPlanet> together = others_of(which);
        together.push_back(candidate.fitted);
        fit_all(together);
        const JointFunctions all(series_, together, together.size());
        const Buffer<double> values = without_planets(series_, together, together.size());
        const std::vector<double> scales =
            jitter_scales_of(series_, all.all(), values, jitters_of(series_, all.all(), values), settings_.rms);
        if (are_near(scales, series_.jitter_scales()))
            return false;
        series_.set_jitter_scales(scales);
        return true;
    }

    static bool are_near(const std::vector<double> &some, const std::vector<double> &others) {
        for (size_t k = 0; k < some.size(); k++)
            if (std::fabs(std::log(some[k] / others[k])) > kMostChange)
                return false;
        return true;
    }

    std::vector<FittedPlanet> others_of(size_t which) const {
        std::vector<FittedPlanet> others = planets_;
        if (which < others.size())
            others.erase(others.begin() + static_cast<std::ptrdiff_t>(which));
        return others;
    }

    // The posterior of the orbits, with the scales of the jitter at hand.
    void examine_orbits(const Problem &problem, const std::vector<Box> &boxes, size_t which, const std::string &stage,
                        double log_null, Candidate &candidate) {
        const Lattice lattice(problem, boxes, settings_.threads, settings_.progress, stage.c_str());
        set_posterior(problem, lattice, log_null, candidate);
        if (const std::optional<FittedPlanet> missed = missed_orbit(which, lattice, candidate))
            examine_near(problem, which, stage, *missed, lattice.log_evidence(), log_null, candidate);
    }

    void set_posterior(const Problem &problem, const Lattice &lattice, double log_null, Candidate &candidate) {
        candidate.log10_bayes = (lattice.log_evidence() - log_null) / std::log(10.0);
        candidate.log10_bayes_error = lattice.log_error() / std::log(10.0);
        candidate.samples = draw_samples(problem, lattice, settings_.samples, settings_.seed, settings_.threads);
        jitter_ = jitter_of(candidate.samples)[1];
        candidate.fitted.planet = best_of(problem, lattice);
        candidate.fitted.scale = std::max(scale_of(series_, candidate.fitted.planet), problem.prior.scales.front());
    }

    // Adds the neighbourhood of an orbit that the lattice has missed: the posterior is there if it has more evidence;
    // otherwise its evidence is an error.
    void examine_near(const Problem &problem, size_t which, const std::string &stage, const FittedPlanet &missed,
                      double log_elsewhere, double log_null, Candidate &candidate) {
        Candidate near = candidate;
        near.fitted = missed;
        describe_best(which, near);
        const Orbit &orbit = missed.planet.orbit;
        const Orbit error = {near.best_error[0] * orbit.frequency * orbit.frequency, near.best_error[1],
                             near.best_error[3] * orbit.frequency};
        if (!(error.frequency > 0 && error.eccentricity > 0 && error.anomaly > 0)) {
            candidate.log10_bayes_error = HUGE_VAL;
            return;
        }
        const Lattice lattice(problem, {box_around(problem, orbit, error)}, settings_.threads, settings_.progress,
                              stage.c_str());
        const double more = lattice.log_evidence() - log_elsewhere;
        if (more > 0)
            set_posterior(problem, lattice, log_null, candidate);
        else
            candidate.log10_bayes_error += std::log1p(std::exp(more)) / std::log(10.0);
    }

    // The candidate that is not a planet, with the orbit of a joint fit.
    void set_rejected(Candidate candidate) {
        std::vector<FittedPlanet> together = planets_;
        together.push_back(candidate.fitted);
        fit_all(together);
        candidate.fitted = together.back();
        rejected_ = std::move(candidate);
    }

    // Computes the posteriors of several planets with all others, until they and the joint fit agree. A planet whose
    // Bayes factor is then below the threshold is removed, and the posteriors of the others are computed again.
    void settle_together() {
        if (planets_.size() < 2)
            return;
        while (!planets_.empty()) {
            examine_all();
            const auto is_weaker = [](const Candidate &a, const Candidate &b) { return a.log10_bayes < b.log10_bayes; };
            const auto weakest = std::min_element(candidates_.begin(), candidates_.end(), is_weaker);
            if (weakest->log10_bayes >= settings_.threshold)
                return;
            Candidate removed = std::move(*weakest);
            planets_.erase(planets_.begin() + (weakest - candidates_.begin()));
            candidates_.erase(weakest);
            fit_all(planets_);
            set_rejected(std::move(removed));
        }
    }

    void examine_all() {
        for (int turn = 0; turn < kMostTurns; turn++) {
            bool has_moved = false;
            for (size_t p = 0; p < planets_.size(); p++) {
                candidates_[p] = examine(p, "planet " + std::to_string(p + 1) + ", with the others");
                has_moved = move_to(candidates_[p].fitted, p) || has_moved;
            }
            if (!has_moved || planets_.size() == 1)
                return;
        }
    }

    // Begins the joint fit again with planet `which` at the maximum of its posterior. Returns whether it is better
    // there.
    bool move_to(const FittedPlanet &fitted, size_t which) {
        planets_[which].scale = fitted.scale;
        std::vector<FittedPlanet> moved = planets_;
        moved[which] = fitted;
        const double here = fit_all(planets_), there = fit_all(moved);
        if (!(there < here - kLeastGain))
            return false;
        planets_ = moved;
        return true;
    }

    double fit_all(std::vector<FittedPlanet> &planets) const {
        return fit_jointly(series_, jitter_, settings_.eccentricity_max, planets);
    }

    void keep_fit(Result &result) {
        result.functions = std::make_unique<JointFunctions>(series_, planets_, planets_.size());
        result.rest = std::make_unique<Problem>(
            Problem{series_, prior_, result.functions->all(), without_planets(series_, planets_, planets_.size())});
        result.design = std::make_unique<Design>(series_, result.rest->functions, result.rest->values, jitter_);
        result.residuals = residuals_of(series_, result.rest->functions, result.rest->values, *result.design);
        for (size_t i = 0; i < series_.n; i++)
            if (series_.factor[i] > 0)
                result.residuals[i] = result.design->residuals()[i] / result.design->weights()[i];
    }

    // Describes a candidate, and finds the reasons that it has of its own.
    void describe_best(size_t which, Candidate &candidate) const {
        std::vector<FittedPlanet> others = others_of(which);
        const JointFunctions without(series_, others, others.size());
        const Design rest(series_, without.all(), without_planets(series_, others, others.size()), jitter_);
        candidate.power_left = power_left(series_, rest, candidate.fitted.planet);
        others.push_back(candidate.fitted);
        const JointFunctions all(series_, others, others.size());
        const Design design(series_, all.all(), without_planets(series_, others, others.size()), jitter_);
        candidate.best = describe(candidate.fitted.planet);
        candidate.best_error =
            errors_of(series_, candidate.fitted.planet, design, without.all().size(), all.all().size());
        set_reasons({rest.square(), design.square()}, rest, candidate);
    }

    // The reasons of one candidate; rest: what the other planets leave.
    void set_reasons(const Squares &squares, const Design &rest, Candidate &candidate) const {
        const Planet &planet = candidate.fitted.planet;
        candidate.log10_fap_orbit = log10_fap_of_orbit(squares, series_, rest, prior_);
        candidate.at_edge = is_at_edge(candidate.samples, planet.orbit, prior_);
        candidate.reasons = 0;
        if (candidate.log10_bayes < settings_.threshold) {
            candidate.reasons = kReasonOdds;
            return;
        }
        uint32_t &reasons = candidate.reasons;
        reasons |=
            reason_if(candidate.log10_bayes - candidate.log10_bayes_error < settings_.threshold, kReasonEvidence);
        reasons |=
            reason_if(std::min(candidate.log10_fap, candidate.log10_fap_orbit) > std::log10(settings_.fap), kReasonFap);
        reasons |= reason_if(candidate.at_edge, kReasonEdge);
        reasons |= reason_if(is_better_outside(squares, series_, rest, prior_), kReasonRange);
        reasons |= reason_if(is_too_heavy(settings_.units, series_, planet), kReasonMass);
    }

    Series &series_;
    const Prior &prior_;
    const Settings &settings_;
    std::vector<FittedPlanet> planets_; // of the joint fit
    std::vector<Candidate> candidates_;
    std::optional<Candidate> rejected_; // the last candidate, which is not a planet
    double jitter_ = 0;                 // of the last posterior
};

} // namespace

Result::Result(const GivenSeries &given, const GivenVelocities &velocities, const Settings &asked)
    : series(given, velocities), frame_chi_square(given.frame_chi_square), settings(asked) {
    set_periods(settings);
    std::vector<bool> left_out = screen(series, 1 / settings.period_max, 1 / settings.period_min);
    for (int round = 0; round < kMostRounds; round++) {
        series.leave_out(left_out);
        std::vector<bool> next = search(asked);
        if (next == left_out)
            break;
        left_out = std::move(next);
    }
    for (size_t i = 0; i < series.n; i++)
        if (series.factor[i] == 0)
            outliers.push_back(i);
    judge();
}

const Candidate &Result::last_fitted() const noexcept {
    const auto is_fitted = [](const Candidate &candidate) { return candidate.is_fitted(); };
    const auto last = std::find_if(candidates.rbegin(), candidates.rend(), is_fitted);
    return last == candidates.rend() ? candidates.front() : *last;
}

std::vector<bool> Result::search(const Settings &asked) {
    settings = settled(series, asked);
    if (settings.jitter && series.median_sigma > 0) {
        settings.jitter = false;
        prior = prior_of(series, settings);
        Searcher trial(series, prior, settings);
        if (trial.run(true, *this))
            return trial.far(*this);
        settings.jitter = true;
    }
    prior = prior_of(series, settings);
    Searcher searcher(series, prior, settings);
    searcher.run(false, *this);
    return searcher.far(*this);
}

// Adds the reasons that all candidates of the joint fit share, and those of pairs: of two planets whose orbits cross,
// the one with smaller odds is none.
void Result::judge() {
    goodness = series_goodness(series, residuals, *design, !settings.clip);
    const Goodness kept = series_goodness(series, residuals, *design, false);
    const Goodness with_jitter = goodness_with_jitter(series, *design);
    chi_square_with_jitter = with_jitter.chi_square;
    const bool has_noise_of_frames = settings.jitter && !settings.units.velocity;
    const uint32_t shared = reason_if(with_jitter.verdict != GoodnessVerdict::good, kReasonChiSquare) |
                            reason_if(has_noise_of_frames && kept.chi_square > kMostSeriesChiSquare, kReasonJitter) |
                            reason_if(frame_chi_square > kMostFrameChiSquare, kReasonFrames) |
                            reason_if(!outliers.empty() && !settings.clip, kReasonSamples);
    for (Candidate &candidate : candidates)
        candidate.reasons |= candidate.is_fitted() ? shared : 0;
    for (Candidate &candidate : candidates)
        for (const Candidate &other : candidates)
            if (candidate.is_planet() && other.is_planet() && candidate.log10_bayes < other.log10_bayes &&
                do_cross(candidate.samples, other.samples))
                candidate.reasons |= kReasonCrossing;
}

} // namespace toliman::planet
