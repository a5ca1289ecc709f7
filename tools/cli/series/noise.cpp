#include "series/noise.hpp"

#include <CLI/App.hpp>
#include <algorithm>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "series/measure.hpp"

namespace cli {

namespace {

constexpr double kMostUnasked = 2.5e7; // samples times frequencies: about 2 s
const char *const kAr1 = "ar1";

std::vector<double> resample(const FapOptions &options, const toliman_measure *series, const FrequencyGrid &grid,
                             double rho, Progress &progress) {
    auto how = toliman::sized<toliman_period_noise_bootstrap_options>();
    how.seed = options.seed;
    how.progress = Progress::callback;
    how.progress_data = &progress;
    std::vector<double> peaks(options.resamplings);
    toliman::check(toliman_measure_query_noise_bootstrap(series, grid.f0, grid.df, grid.nf, rho, &how, peaks.size(),
                                                         peaks.data()));
    return peaks;
}

} // namespace

void add_noise(CLI::App &command, NoiseOptions &options) {
    command
        .add_option("--noise", options.model, "noise between samples: white (default), or ar1, correlated (see above)")
        ->check(CLI::IsMember({"white", kAr1}));
}

Noise::Noise(const NoiseOptions &options, const FapOptions &fap, const Series &series, FrequencyGrid grid,
             double frequency, Progress &progress)
    : model_(options.model) {
    if (!is_ar1()) {
        grid.nf = std::min(grid.nf, static_cast<int64_t>(kMostUnasked / static_cast<double>(series.t.size())));
        if (grid.f0 + grid.df * static_cast<double>(grid.nf) < frequency)
            return;
    }
    try {
        const toliman::measurements input = measure_of(series, 0, 0);
        search(input.get(), grid, progress);
        if (is_ar1() && fap.method == kBootstrap)
            resampled_ = Resampled{resample(fap, input.get(), grid, found_->rho, progress)};
    } catch (const toliman::error &error) {
        const bool unsuited = error.status() == TOLIMAN_E_STATE || error.status() == TOLIMAN_E_ARGUMENT;
        if (unsuited && is_ar1())
            malformed(series.name, std::string("--noise ar1: ") + error.what());
        if (!unsuited)
            throw;
    }
}

void Noise::search(const toliman_measure *series, const FrequencyGrid &grid, Progress &progress) {
    auto options = toliman::sized<toliman_period_noise_options>();
    options.flags = is_ar1() ? 0 : TOLIMAN_PERIOD_WHITE_NOISE;
    options.progress = Progress::callback;
    options.progress_data = &progress;
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
