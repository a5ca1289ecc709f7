// Method: for each hypothesis, the sum S of squares that a mean, a year's harmonics and the errors of the orbit leave
// of the residuals (residuals.hpp) is compared with that without the hypothesis. Time and rotations have one parameter:
// a grid, on which the effect of velocities alone is computed, finds the minima of S, from which Gauss-Newton steps
// with exact residuals begin. Exchanged axes are a list. A relative error of the plate scale is linear; the mean would
// hide it, and is left out for it. The significance of a gain is sqrt(gain/max(1, chi-square after)): residuals that
// the hypothesis does not explain count as noise, so that nothing is claimed of data that are wrong for another reason.
// About 600 values are tried; of these the largest exceeds 5.5 by chance once in 4e4 missions. kDecisive is above that,
// as noise has tails. A gain that comes from fewer than kLeastShared measurements is that of outliers. Times: the orbit
// of the spacecraft repeats, and so do the minima, every 97 minutes. Of those that fit equally well a known offset
// comes first, then the smallest.
#include "sky/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>

#include "base/constants.hpp"
#include "base/robust.hpp"
#include "sky/residuals.hpp"
#include "sky/time.hpp"

namespace toliman::sky {

namespace {

constexpr size_t kMost = 4096, kLeast = 30;               // measurements
constexpr double kLeastSigma = 0.1;                       // of the median
constexpr double kDecisive = 7;                           // standard deviations
constexpr double kLeastShared = 5;                        // measurements
constexpr double kAlike = 9;                              // difference of sums of squares, in units of chi-square
constexpr double kLongestShift = 90000, kShiftStep = 450; // s; a twelfth of a low orbit
constexpr double kTurnStep = 10;                          // deg
constexpr size_t kMostMinima = 6;
constexpr int kMostRefinements = 8;
constexpr double kStillSigmas = 0.02; // standard deviations
constexpr Matrix kNoState = {};       // the Earth's centre

using Values = Residuals::Values;
using Free = Residuals::Free;

double squares(const std::vector<double> &values) noexcept {
    double sum = 0;
    for (const double value : values)
        sum += value * value;
    return sum;
}

// The number of measurements that share the difference of two sums of squares.
double shared(const std::vector<double> &before, const std::vector<double> &after, size_t measurements) noexcept {
    double sum = 0, square = 0;
    for (size_t m = 0; m < measurements; m++) {
        const double gain = before[m] * before[m] - after[m] * after[m];
        sum += gain;
        square += gain * gain;
    }
    return square > 0 ? sum * sum / square : 0;
}

// Decimals that show the first digit of a standard deviation.
int digits_of(double sigma) noexcept {
    return std::isfinite(sigma) && sigma > 0 ? std::clamp(-static_cast<int>(std::floor(std::log10(sigma))), 0, 9) : 0;
}

// "37.0 +- 0.2".
std::string plus_minus(double value, double sigma) {
    char text[80];
    std::snprintf(text, sizeof text, "%.*f +- %.*f", digits_of(sigma), value, digits_of(sigma), sigma);
    return text;
}

// A family of changes with one parameter.
struct Family {
    std::function<Change(double)> change;
    double first, last, step;
    std::function<std::string(double, double)> known; // name of a value with its standard deviation, or ""
};

class Trial {
  public:
    explicit Trial(const Residuals &residuals)
        : residuals_(residuals), before_(residuals.rest(residuals.before(), residuals.before(), Free::slow)) {}

    // What a hypothesis leaves, compared with none for the same measurements. fitted: its parameters.
    Hypothesis judge(const Values &after, size_t fitted, Free free = Free::slow) const {
        const auto used = static_cast<size_t>(
            std::count_if(after.begin(), after.end(), [](double value) { return !std::isnan(value); }));
        const bool is_cached = used == after.size() && free == Free::slow;
        const std::vector<double> before = is_cached ? before_ : residuals_.rest(residuals_.before(), after, free);
        const std::vector<double> rest = residuals_.rest(after, after, free);
        const double freedom = static_cast<double>(used) - static_cast<double>(fitted + static_cast<size_t>(free));
        Hypothesis out = {kNaN, kNaN, squares(rest) / freedom, squares(before) - squares(rest), 0, false, ""};
        out.significance = std::sqrt(std::max(0.0, out.gain) / std::max(1.0, out.chi_square));
        out.is_decisive = 2 * used >= after.size() && out.significance >= kDecisive &&
                          (free == Free::none || shared(before, rest, after.size()) >= kLeastShared);
        return out;
    }

    Hypothesis best_of(const Family &family) const {
        std::vector<Hypothesis> found;
        for (const double start : minima(family))
            found.push_back(refined(family, start));
        double most = 0, chi_square = 0;
        for (const Hypothesis &one : found)
            if (one.gain >= most) {
                most = one.gain;
                chi_square = std::max(1.0, one.chi_square);
            }
        const auto alike = [&](const Hypothesis &one) { return one.gain >= most - kAlike * chi_square; };
        const auto named = [&](const Hypothesis &one) {
            return family.known && !family.known(one.value, one.sigma).empty();
        };
        const auto comes_first = [&](const Hypothesis &a, const Hypothesis &b) {
            if (alike(a) != alike(b))
                return alike(a);
            if (named(a) != named(b))
                return named(a);
            return std::fabs(a.value) < std::fabs(b.value);
        };
        return *std::min_element(found.begin(), found.end(), comes_first);
    }

    // The simplest of those that explain the residuals best; its place in the list.
    Hypothesis best_of(const std::vector<Axes> &list, size_t &place) const {
        std::vector<double> gains;
        for (const Axes &axes : list)
            gains.push_back(judge(residuals_.estimate({0, axes.matrix}), 0).gain);
        place = static_cast<size_t>(std::max_element(gains.begin(), gains.end()) - gains.begin());
        const double chi_square = judge(residuals_.estimate({0, list[place].matrix}), 0).chi_square;
        for (size_t i = place; i-- > 0;)
            if (gains[i] >= gains[place] - kAlike * std::max(1.0, chi_square))
                place = i;
        return judge(residuals_.after({0, list[place].matrix}), 0);
    }

    // The scale is linear: measured = (1 + k) true.
    Hypothesis scale() const {
        const Values &before = residuals_.before();
        const std::vector<double> rest = residuals_.rest(before, before, Free::none);
        const std::vector<double> by_scale = residuals_.rest(residuals_.scale(), before, Free::none);
        const double value = -dot(by_scale, rest) / squares(by_scale);
        Values after = before;
        const Values slope = residuals_.scale();
        for (size_t m = 0; m < after.size(); m++)
            after[m] += value * slope[m];
        Hypothesis out = judge(after, 1, Free::none);
        set_value(out, value, squares(by_scale));
        return out;
    }

  private:
    static double dot(const std::vector<double> &a, const std::vector<double> &b) noexcept {
        double sum = 0;
        for (size_t i = 0; i < a.size(); i++)
            sum += a[i] * b[i];
        return sum;
    }

    static void set_value(Hypothesis &out, double value, double information) noexcept {
        out.value = value;
        out.sigma = std::sqrt(std::max(1.0, out.chi_square) / information);
    }

    // The starting points of the best minima.
    std::vector<double> minima(const Family &family) const {
        std::vector<std::pair<double, double>> grid; // gain, value
        for (double value = family.first; value <= family.last; value += family.step)
            grid.emplace_back(judge(residuals_.estimate(family.change(value)), 1).gain, value);
        std::vector<std::pair<double, double>> peaks;
        for (size_t i = 0; i < grid.size(); i++)
            if ((i == 0 || grid[i].first >= grid[i - 1].first) &&
                (i + 1 == grid.size() || grid[i].first > grid[i + 1].first))
                peaks.push_back(grid[i]);
        std::sort(peaks.rbegin(), peaks.rend());
        std::vector<double> starts = {0};
        for (size_t i = 0; i < std::min(peaks.size(), kMostMinima); i++)
            starts.push_back(peaks[i].second);
        return starts;
    }

    // Gauss-Newton steps, the first of them with estimated residuals.
    Hypothesis refined(const Family &family, double value) const {
        double information = 1;
        for (const bool exact : {false, true})
            for (int step = 0; step < kMostRefinements; step++) {
                const Change change = family.change(value);
                const Values now = exact ? residuals_.after(change) : residuals_.estimate(change);
                const double small = family.step * 1e-3;
                Values slope = residuals_.estimate(family.change(value + small));
                const Values below = residuals_.estimate(family.change(value - small));
                for (size_t m = 0; m < slope.size(); m++)
                    slope[m] = (slope[m] - below[m]) / (2 * small);
                Values used = now; // NaN where one of them is
                for (size_t m = 0; m < used.size(); m++)
                    used[m] += slope[m];
                const std::vector<double> rest = residuals_.rest(now, used, Free::slow);
                const std::vector<double> by_value = residuals_.rest(slope, used, Free::slow);
                information = squares(by_value);
                if (!(information > 0))
                    break;
                const double move = -dot(by_value, rest) / information;
                value += std::clamp(move, -family.step, family.step);
                if (std::fabs(move) * std::sqrt(information) <= kStillSigmas)
                    break;
            }
        Hypothesis out = judge(residuals_.after(family.change(value)), 1);
        set_value(out, value, information);
        return out;
    }

    const Residuals &residuals_;
    const std::vector<double> before_; // what is left without a hypothesis
};

Family shifts(double exposure_s) {
    const auto known = [exposure_s](double value, double sigma) { return mistake_of(value, sigma, exposure_s); };
    return {[](double seconds) {
                return Change{seconds, kSameAxes};
            },
            -kLongestShift, kLongestShift, kShiftStep, known};
}

Family turns(size_t axis) {
    return {[axis](double degrees) {
                return Change{0, rotation(axis, degrees * kDegree)};
            },
            -180, 180 - kTurnStep, kTurnStep, nullptr};
}

std::string text_of_time(const Hypothesis &one, double exposure_s) {
    const std::string known = mistake_of(one.value, one.sigma, exposure_s);
    return (one.value > 0 ? "times are late by " : "times are early by ") +
           plus_minus(std::fabs(one.value), one.sigma) + " s" + (known.empty() ? "" : ": " + known + "?");
}

std::string text_of_turn(const Hypothesis &one, char axis) {
    return "the observer's states are turned about their axis " + std::string(1, axis) + " by " +
           plus_minus(one.value, one.sigma) + " deg";
}

std::string text_of_scale(const Hypothesis &one) {
    return "separations are " + plus_minus(100 * std::fabs(one.value), 100 * one.sigma) + " % too " +
           (one.value > 0 ? "large" : "small") + ": are plate scale and system right?";
}

// Without a state there is nothing that time and axes could change.
std::vector<Hypothesis> try_all(const Residuals &residuals, bool in_orbit) {
    const Trial trial(residuals);
    const Hypothesis unknown = {kNaN, kNaN, kNaN, 0, 0, false, ""};
    std::vector<Hypothesis> all(kCauses, unknown);
    const auto at = [&](Cause cause) -> Hypothesis & { return all[static_cast<size_t>(cause) - 1]; };
    if (residuals.count() < kLeast)
        return all;
    Hypothesis &scale = at(Cause::scale);
    scale = trial.scale();
    scale.text = text_of_scale(scale);
    if (!in_orbit)
        return all;
    const double exposure_s = residuals.exposure_s();
    Hypothesis &time = at(Cause::time);
    time = trial.best_of(shifts(exposure_s));
    time.text = text_of_time(time, exposure_s);
    const std::vector<Axes> list = wrong_axes(terrestrial_days(residuals.middle_ns()));
    size_t place = 0;
    at(Cause::axes) = trial.best_of(list, place);
    at(Cause::axes).text = list[place].text;
    const Cause rotations[] = {Cause::rotation_x, Cause::rotation_y, Cause::rotation_z};
    for (size_t axis = 0; axis < 3; axis++) {
        Hypothesis &turn = at(rotations[axis]);
        turn = trial.best_of(turns(axis));
        turn.text = text_of_turn(turn, "xyz"[axis]);
    }
    at(Cause::centre) = trial.judge(residuals.after({0, kNoState}), 0);
    at(Cause::centre).text =
        "the separations are those at the Earth's centre: are they corrected for the velocity of the spacecraft?";
    return all;
}

// Standard deviations far below the others would decide alone: they are raised. Empty if there are none.
std::vector<Measurement> without_extremes(const std::vector<Measurement> &measurements) {
    std::vector<double> sigmas;
    for (const Measurement &one : measurements)
        sigmas.push_back(one.sigma_arcsec);
    const double least = kLeastSigma * median(sigmas);
    if (std::none_of(sigmas.begin(), sigmas.end(), [least](double sigma) { return sigma < least; }))
        return {};
    std::vector<Measurement> raised = measurements;
    for (Measurement &one : raised)
        one.sigma_arcsec = std::max(one.sigma_arcsec, least);
    return raised;
}

// The simplest of the decisive hypotheses that explain the residuals best. A shift of time by half a revolution looks
// like reversed axes.
Cause cause_of(const std::vector<Hypothesis> &all, double exposure_s) {
    constexpr Cause kSimplestFirst[] = {Cause::centre,     Cause::axes,       Cause::time,      Cause::scale,
                                        Cause::rotation_x, Cause::rotation_y, Cause::rotation_z};
    const auto at = [&](Cause cause) -> const Hypothesis & { return all[static_cast<size_t>(cause) - 1]; };
    double most = 0, chi_square = 1;
    for (const Hypothesis &one : all)
        if (one.is_decisive && one.gain > most) {
            most = one.gain;
            chi_square = std::max(1.0, one.chi_square);
        }
    const auto is_best = [&](Cause cause) {
        return at(cause).is_decisive && at(cause).gain >= most - kAlike * chi_square;
    };
    const Hypothesis &time = at(Cause::time);
    if (is_best(Cause::time) && !mistake_of(time.value, time.sigma, exposure_s).empty())
        return Cause::time;
    for (const Cause cause : kSimplestFirst)
        if (is_best(cause))
            return cause;
    return Cause::none;
}

} // namespace

Diagnosis diagnose(const Predictor &predictor, const std::vector<Measurement> &measurements, double scale_sigma,
                   bool hypotheses) {
    const Residuals residuals(predictor, measurements, scale_sigma, kMost);
    Diagnosis out;
    out.used = residuals.count();
    const double freedom = static_cast<double>(out.used) - 1;
    if (freedom > 0) {
        const std::vector<double> rest = residuals.rest(residuals.before(), residuals.before(), Free::mean);
        double largest = 0;
        for (size_t m = 0; m < out.used; m++)
            largest = std::max(largest, std::fabs(rest[m]));
        out.goodness =
            goodness_of(squares(rest) / freedom, chi_square_sigma(out.used, 0, freedom), largest, kSeriesSigmas);
    }
    if (!hypotheses || measurements.empty())
        return out;
    const bool in_orbit = predictor.observer().kind() != Observer::Kind::earth;
    const std::vector<Measurement> raised = without_extremes(measurements);
    out.hypotheses = try_all(raised.empty() ? residuals : Residuals(predictor, raised, scale_sigma, kMost), in_orbit);
    out.cause = cause_of(out.hypotheses, residuals.exposure_s());
    return out;
}

} // namespace toliman::sky
