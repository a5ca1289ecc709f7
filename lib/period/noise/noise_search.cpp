// Method: rho is fitted by restricted likelihood twice: without a sinusoid (rho_0), and with one (rho_1) at each of the
// ten highest peaks of the white and of the whitened periodogram, which is computed again until no peak is new. A peak
// is refined between the grid's points first: what a strong sinusoid leaves there would be taken for correlated noise.
// The periodogram uses the mean of both fits, in atanh rho, with the weight w of rho_0:
//   w = 1 while noise alone explains the series: FAP of the likelihood ratio of both models above kNoiseAlone,
//   w = 0 once it does not: below kSignal; linear in log10 FAP between.
// Why: for noise, rho_1 belongs to the sinusoid that was chosen because it removes most of the correlation. It is too
// small, and false alarms are too many: 1.3, 1.4, 1.8 and 3.6 % at a FAP of 1 % for rho = 0, 0.2, 0.5, 0.9 and N = 200.
// With rho_0, as in a score test (Rao 1948, Proc. Camb. Phil. Soc. 44, 50), they are 0.6 to 0.8 %. For a strong signal,
// rho_0 takes the signal for noise, and rho_1 does not.
// Rejected: the FAP of the likelihood ratio itself (0.9, 1.6, 1.6 % for rho = 0, 0.5, 0.9); Student's distribution with
// the error of the noise spectrum at the frequency of the peak (0.7 to 1.7 %): both would cost a strong slow signal in
// white noise about 10 % of its log10 FAP (estimated).
#include "period/noise/noise_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/constants.hpp"
#include "period/fap.hpp"

namespace toliman::period {

namespace {

constexpr size_t kCandidates = 10;
constexpr int kMostRounds = 6;
constexpr double kNoiseAlone = -4, kSignal = -8; // log10 FAP
constexpr double kRounding = 1e-20;              // of the residual without a sinusoid
constexpr double kGolden = 0.38196601125010515;  // 2 - golden ratio

struct Maximum {
    double at, value;
};

// Maximum on [low, high], bracketed by `intervals` equal steps.
template <class Function> Maximum maximise(double low, double high, int intervals, int steps, Function f) {
    const double width = (high - low) / intervals;
    Maximum best = {low, f(low)};
    for (int i = 1; i <= intervals; i++) {
        const double x = low + i * width, value = f(x);
        if (value > best.value)
            best = {x, value};
    }
    double from = std::max(low, best.at - width), to = std::min(high, best.at + width);
    Maximum a = {from + kGolden * (to - from), 0}, b = {to - kGolden * (to - from), 0};
    a.value = f(a.at);
    b.value = f(b.at);
    for (int i = 0; i < steps; i++)
        if (a.value > b.value) {
            to = b.at;
            b = a;
            a.at = from + kGolden * (to - from);
            a.value = f(a.at);
        } else {
            from = a.at;
            a = b;
            b.at = to - kGolden * (to - from);
            b.value = f(b.at);
        }
    for (const Maximum &found : {a, b})
        if (found.value > best.value)
            best = found;
    return best;
}

double rho_of(double x) noexcept {
    return std::min(kMaxRho, std::tanh(x));
}

struct NoiseLevel {
    double x;                          // atanh rho
    double likelihood, profile, white; // restricted, without restriction, and restricted of white noise
};

// Leaves the model at the fitted rho.
NoiseLevel fit_noise(NoiseModel &model, double frequency) {
    const NoiseWave wave = model.wave(frequency);
    const auto likelihood = [&](double x) {
        model.set_rho(rho_of(x));
        return model.log_likelihood(model.fit(wave));
    };
    const double white = likelihood(0);
    const Maximum best = maximise(0, std::atanh(kMaxRho), 8, 18, likelihood);
    model.set_rho(rho_of(best.at));
    return {best.at, best.value, model.log_profile(model.fit(wave)), white};
}

// Indices of the highest local maxima.
std::vector<size_t> highest(const double *power, size_t nf) {
    std::vector<size_t> found;
    for (size_t k = 0; k < nf; k++)
        if ((k == 0 || power[k] > power[k - 1]) && (k + 1 == nf || power[k] >= power[k + 1]))
            found.push_back(k);
    const size_t most = std::min(found.size(), kCandidates);
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(most), found.end(),
                      [&](size_t a, size_t b) { return power[a] > power[b] || (power[a] == power[b] && a < b); });
    found.resize(most);
    return found;
}

// The frequency of the smallest residual next to a grid point, for the noise that the model has. The grid point itself
// if only rounding errors are smaller elsewhere.
double refined(NoiseModel &model, const NoiseGrid &grid, double peak) {
    const double from = std::max(grid.f0, peak - grid.df), to = std::min(grid.last(), peak + grid.df);
    if (!(to > from))
        return peak;
    const NoiseFit at_peak = model.fit(model.wave(peak));
    const Maximum best = maximise(from, to, 2, 40, [&](double f) { return -model.fit(model.wave(f)).residual; });
    return at_peak.residual + best.value > kRounding * at_peak.null_residual ? best.at : peak;
}

class Search {
  public:
    Search(NoiseModel &model, const NoiseGrid &grid, const Progress &progress, double *power)
        : model_(model), grid_(grid), progress_(progress), power_(power) {}

    // Fits the noise; the powers are those of white noise afterwards, or of the fitted noise.
    void fit(bool white);
    double log10_p_white() const noexcept;

  private:
    void powers(double rho) {
        model_.set_rho(rho);
        model_.powers(grid_.f0, grid_.df, grid_.nf, power_);
    }
    bool add_candidates();
    double weight_of_noise(double profile) const noexcept;

    NoiseModel &model_;
    const NoiseGrid &grid_;
    const Progress &progress_;
    double *power_;
    std::vector<size_t> tried_;
    NoiseLevel best_ = {0, -std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity()}; // each the largest of any candidate
};

// Fits the noise with a sinusoid at the highest peaks. False if all were tried before.
bool Search::add_candidates() {
    const double rho = model_.rho();
    bool added = false;
    for (size_t k : highest(power_, grid_.nf)) {
        if (std::find(tried_.begin(), tried_.end(), k) != tried_.end())
            continue;
        added = true;
        tried_.push_back(k);
        model_.set_rho(rho); // of this periodogram, not that fitted to the last peak
        const NoiseLevel found = fit_noise(model_, refined(model_, grid_, grid_.at(k)));
        best_.white = std::max(best_.white, found.white);
        best_.profile = std::max(best_.profile, found.profile);
        if (found.likelihood > best_.likelihood) {
            best_.likelihood = found.likelihood;
            best_.x = found.x;
        }
    }
    return added;
}

void Search::fit(bool white) {
    powers(0);
    for (int round = 0; round < kMostRounds && add_candidates(); round++) {
        progress_.report("noise", static_cast<double>(round) / kMostRounds);
        powers(rho_of(best_.x));
    }
    const NoiseLevel alone = fit_noise(model_, 0);
    const double weight = weight_of_noise(alone.profile);
    powers(white ? 0 : rho_of(weight * alone.x + (1 - weight) * best_.x));
}

double Search::weight_of_noise(double profile) const noexcept {
    const double gain = std::max(0.0, best_.profile - profile);
    const double log10_residual = -2 * gain / static_cast<double>(model_.samples()) / std::log(10.0);
    const double fap = log10_fap(model_, grid_, log10_residual);
    return std::clamp((fap - kSignal) / (kNoiseAlone - kSignal), 0.0, 1.0);
}

// rho is at least 0, so that white noise gives a likelihood ratio of 0 with a probability of one half (Self and Liang
// 1987, J. Am. Stat. Assoc. 82, 605).
double Search::log10_p_white() const noexcept {
    const double half = std::max(0.0, best_.likelihood - best_.white), z = std::sqrt(half);
    if (half == 0)
        return 0;
    if (half > 300) // asymptotic series of erfc
        return (-half - std::log(2 * z * std::sqrt(kPi)) - 0.5 / half) / std::log(10.0);
    return std::log10(0.5 * std::erfc(z));
}

} // namespace

double log10_fap(const NoiseModel &model, const NoiseGrid &grid, double log10_residual) noexcept {
    // N - K degrees of freedom, where Sampling assumes K = 1.
    const auto count = static_cast<int64_t>(model.samples() - model.free_functions() + 1);
    return log10_fap(Fap::baluev, {count, grid.last(), model.time_variance()},
                     std::clamp(log10_residual, kMinLogResidual, 0.0));
}

NoiseResult search_noise(NoiseModel &model, const NoiseGrid &grid, bool white, const Progress &progress, double *power,
                         double *coefficients, double *errors) {
    model.set_rho(0);
    model.check();
    Search search(model, grid, progress, power);
    search.fit(white);
    NoiseResult result = {};
    result.rho = model.rho();
    result.rho_error = model.rho_error();
    result.log10_p_white = search.log10_p_white();
    result.index = static_cast<size_t>(std::max_element(power, power + grid.nf) - power);
    result.power = power[result.index];
    const double peak = grid.at(result.index);
    const NoiseFit on_grid = model.fit(model.wave(peak));
    result.log10_residual = std::clamp(std::log10(on_grid.residual / on_grid.null_residual), kMinLogResidual, 0.0);
    result.log10_fap = log10_fap(model, grid, result.log10_residual);
    result.frequency = refined(model, grid, peak);
    const NoiseWave wave = model.wave(result.frequency);
    result.rank = model.fit(wave).rank;
    result.solution = model.solve(wave, coefficients, errors);
    return result;
}

} // namespace toliman::period
