// Method: analytic FAPs come from the library. The bootstrap draws for each time a value with its sigma, with
// replacement, takes the highest peak of each resampling on the same grid, and estimates FAP = (k + 1)/(n + 1), where k
// of n resamplings have a peak at least as high. Adding 1 keeps the estimate above 0 and conservative; k = 0 is printed
// as an upper bound. All comparisons use log10(1 - power), which keeps digits if the power is close to 1.
#include "series/fap.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

const std::map<std::string, int32_t> kMethods = {{"baluev", TOLIMAN_PERIOD_FAP_BALUEV},
                                                 {"naive", TOLIMAN_PERIOD_FAP_NAIVE},
                                                 {"single", TOLIMAN_PERIOD_FAP_SINGLE},
                                                 {"sequential", TOLIMAN_PERIOD_FAP_SEQUENTIAL}};

std::vector<double> resample(const FapOptions &options, const toliman::periodogram &periodogram, const Series &series,
                             Progress &progress) {
    auto how = toliman::sized<toliman_period_bootstrap_options>();
    how.seed = options.seed;
    how.progress = Progress::callback;
    how.progress_data = &progress;
    const std::vector<double> rows = series.nuisance.rows();
    how.rows = rows.empty() ? nullptr : rows.data();
    std::vector<double> peaks(options.resamplings);
    toliman::check(toliman_period_query_bootstrap(periodogram.get(), series.t.data(), series.y.data(),
                                                  series.sigma.empty() ? nullptr : series.sigma.data(), series.t.size(),
                                                  &how, peaks.size(), peaks.data()));
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
    command.add_option("--fap", options.method, "method of the false alarm probability (see above), default baluev")
        ->check(CLI::IsMember(names));
    command.add_option("--resamplings", options.resamplings, "number of resamplings of --fap bootstrap, default 1000")
        ->check(CLI::Range(1u, 1000000u));
    add_seed(command, options.seed, "seed of --fap bootstrap, default 0");
}

Fap::Fap(const FapOptions &options, const toliman::periodogram &periodogram, const Series *series, Progress &progress)
    : periodogram_(periodogram), method_(options.method) {
    if (method_ != kBootstrap)
        return;
    if (series == nullptr)
        throw Failure(kExitUsage, "--fap bootstrap: needs the samples, so it excludes --from-state");
    resampled_.peaks = resample(options, periodogram, *series, progress);
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

} // namespace cli
