// Method: analytic FAPs come from the library. The bootstrap draws for each time a value with its sigma, with
// replacement, takes the highest peak of each resampling on the same grid, and estimates FAP = (k + 1)/(n + 1), where k
// of n resamplings have a peak at least as high. Adding 1 keeps the estimate above 0 and conservative; k = 0 is printed
// as an upper bound. All comparisons use log10(1 - power), which keeps digits if the power is close to 1.
#include "series/fap.hpp"

#include <CLI/App.hpp>

#include "options/command.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

const std::map<std::string, int32_t> kMethods = {{"baluev", TOLIMAN_PERIOD_FAP_BALUEV},
                                                 {"naive", TOLIMAN_PERIOD_FAP_NAIVE},
                                                 {"single", TOLIMAN_PERIOD_FAP_SINGLE},
                                                 {"sequential", TOLIMAN_PERIOD_FAP_SEQUENTIAL}};

std::vector<double> resample(const FapOptions &options, const toliman::periodogram &periodogram,
                             const toliman_measure *series, Progress &progress) {
    auto how = with_progress<toliman_period_bootstrap_options>(progress);
    how.seed = options.seed;
    const std::vector<double> rows = column_rows(series);
    const Samples samples(series);
    how.rows = rows.empty() ? nullptr : rows.data();
    std::vector<double> peaks(options.resamplings);
    toliman::check(toliman_period_query_bootstrap(periodogram.get(), samples.t.data(), samples.y.data(),
                                                  samples.sigmas(), samples.count(), &how, peaks.size(), peaks.data()));
    return peaks;
}

constexpr double kMostUnasked = 2.5e7; // samples times frequencies: about 2 s
const char *const kAr1 = "ar1";

std::vector<double> resample(const FapOptions &options, const toliman_measure *series, const FrequencyGrid &grid,
                             double rho, Progress &progress) {
    auto how = with_progress<toliman_period_noise_bootstrap_options>(progress);
    how.seed = options.seed;
    std::vector<double> peaks(options.resamplings);
    toliman::check(toliman_measure_query_noise_bootstrap(series, grid.f0, grid.df, grid.nf, rho, &how, peaks.size(),
                                                         peaks.data()));
    return peaks;
}

} // namespace

double power_at_fap_1e_3(const toliman_period *period) {
    double log10_residual = 0;
    const toliman_status status =
        toliman_period_query_threshold(period, TOLIMAN_PERIOD_FAP_BALUEV, -3, &log10_residual);
    if (status == TOLIMAN_E_STATE || status == TOLIMAN_E_RANGE)
        return NAN;
    toliman::check(status);
    return 1 - std::pow(10, log10_residual);
}

void add_fap(CLI::App &command, FapOptions &options) {
    std::vector<std::string> names = {kBootstrap};
    for (const auto &[name, method] : kMethods)
        names.push_back(name);
    command.add_option("--fap", options.method)->check(CLI::IsMember(names));
    command.add_option("--resamplings", options.resamplings)->check(CLI::Range(1u, 1000000u));
    add_seed(command, options.seed);
}

Fap::Fap(const FapOptions &options, const toliman::periodogram &periodogram, const toliman_measure *series,
         Progress &progress)
    : periodogram_(periodogram), method_(options.method) {
    if (method_ != kBootstrap)
        return;
    if (series == nullptr)
        throw Failure(kExitUsage, "--fap bootstrap: needs the samples, so it excludes --from-state");
    resampled_.peaks = resample(options, periodogram, series, progress);
}

double Fap::residual_of(const toliman_period_peak &fitted) const {
    if (method_ != kBootstrap)
        return fitted.log10_residual;
    auto peak = toliman::sized<toliman_period_peak>();
    toliman::check(toliman_period_query_peak(periodogram_.get(), &peak));
    return peak.log10_residual;
}

double Fap::log10(double log10_residual) const {
    if (method_ == kBootstrap)
        return resampled_.log10(log10_residual);
    double log10_fap = 0;
    toliman::check(toliman_period_query_fap(periodogram_.get(), kMethods.at(method_), log10_residual, &log10_fap));
    return log10_fap;
}

std::string Fap::text(double log10_residual) const {
    const bool is_bound = method_ == kBootstrap && resampled_.is_bound(log10_residual);
    return formatted("%s%.2f", is_bound ? "< " : "", log10(log10_residual));
}

std::string Fap::with_method(double log10_residual) const {
    return method_ == kBootstrap ? resampled_.text(log10_residual) : text(log10_residual) + " (" + method_ + ")";
}

// Number of resamplings with a peak at least as high.
std::ptrdiff_t Resampled::above(double log10_residual) const {
    return std::upper_bound(peaks.begin(), peaks.end(), log10_residual) - peaks.begin();
}

double Resampled::log10(double log10_residual) const {
    return std::log10(static_cast<double>(above(log10_residual) + 1) / static_cast<double>(peaks.size() + 1));
}

std::string Resampled::text(double log10_residual) const {
    const double fap = log10(log10_residual);
    return is_bound(log10_residual) ? formatted("< %.2f (bootstrap, none of %zu)", fap, peaks.size())
                                    : formatted("%.2f (bootstrap)", fap);
}

void add_noise(CLI::App &command, NoiseOptions &options) {
    command.add_option("--noise", options.model)->check(CLI::IsMember({"white", kAr1}));
}

Noise::Noise(const NoiseOptions &options, const FapOptions &fap, const toliman_measure *series, FrequencyGrid grid,
             double frequency, Progress &progress)
    : model_(options.model) {
    if (!is_ar1()) {
        grid.nf = std::min(grid.nf, static_cast<int64_t>(kMostUnasked / static_cast<double>(info_of(series).n)));
        if (grid.f0 + grid.df * static_cast<double>(grid.nf) < frequency)
            return;
    }
    try {
        search(series, grid, progress);
        if (is_ar1() && fap.method == kBootstrap)
            resampled_ = Resampled{resample(fap, series, grid, found_->rho, progress)};
    } catch (const toliman::error &error) {
        const bool unsuited = error.status() == TOLIMAN_E_STATE || error.status() == TOLIMAN_E_ARGUMENT;
        if (unsuited && is_ar1())
            malformed(name_of(series), std::string("--noise ar1: ") + error.what());
        if (!unsuited)
            throw;
    }
}

void Noise::search(const toliman_measure *series, const FrequencyGrid &grid, Progress &progress) {
    auto options = with_progress<toliman_period_noise_options>(progress);
    options.flags = is_ar1() ? 0 : TOLIMAN_PERIOD_WHITE_NOISE;
    auto found = toliman::sized<toliman_period_noise>();
    coefficients_.resize(static_cast<size_t>(info_of(series).functions));
    errors_.resize(coefficients_.size());
    toliman::check(toliman_measure_query_noise(series, grid.f0, grid.df, grid.nf, &options, nullptr,
                                               coefficients_.data(), errors_.data(), &found));
    found_ = found;
}

bool Noise::is_ar1() const {
    return model_ == kAr1;
}

void Noise::set(std::vector<Coefficient> &coefficients) const {
    for (size_t i = 0; i < coefficients.size(); i++) {
        coefficients[i].value = (i == 0 ? found_->offset : coefficients_[i - 1]) * coefficients[i].unit;
        coefficients[i].error = (i == 0 ? found_->offset_error : errors_[i - 1]) * coefficients[i].unit;
    }
}

void Noise::warn(Progress &progress) const {
    if (found_ && !is_ar1() && found_->log10_p_white < kNotWhite)
        progress.warn(
            formatted("values are correlated (whiteness: log10 p = %.3g): false alarm probabilities for white "
                      "noise are too small: --noise ar1",
                      found_->log10_p_white));
}

void Noise::print() const {
    if (!found_ || !is_ar1())
        return;
    const toliman_period_noise &found = *found_;
    std::printf("noise       ar1: correlation %.3f +- %.2g over %.6g, white with log10 p = %.3g\n", found.rho,
                found.rho_error, found.step, found.log10_p_white);
    std::printf(
        "with ar1    period %s, amplitude %s, power %.6f, log10 FAP %s\n",
        text_with_error(found.period, found.period_error).c_str(),
        text_with_error(found.amplitude, found.amplitude_error).c_str(), found.power,
        (resampled_ ? resampled_->text(found.log10_residual) : formatted("%.3f (baluev)", found.log10_fap)).c_str());
}

Json Noise::json() const {
    const toliman_period_noise &found = *found_;
    Json json("model", model_, "log10_p_white", found.log10_p_white);
    if (!is_ar1())
        return json;
    json.set("rho", found.rho);
    json.set("rho_error", found.rho_error);
    json.set("step", found.step);
    json.set("tau", found.tau);
    json.set("peak",
             Json("frequency", found.frequency, "frequency_error", found.frequency_error, "period", found.period,
                  "period_error", found.period_error, "power", found.power, "log10_residual", found.log10_residual,
                  "amplitude", found.amplitude, "amplitude_error", found.amplitude_error, "phase", found.phase,
                  "time_offset", found.time_reference, "offset", found.offset, "log10_fap",
                  resampled_ ? resampled_->log10(found.log10_residual) : found.log10_fap, "fap_method",
                  resampled_ ? kBootstrap : "baluev", "at_edge", (found.flags & TOLIMAN_PERIOD_AT_EDGE) != 0));
    return json;
}

} // namespace cli
