#include "series/noise.hpp"

#include <CLI/CLI.hpp>

#include "common/failure.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr double kNotWhite = -3;       // log10 p of the whiteness test
constexpr double kMostUnasked = 2.5e7; // samples times frequencies: about 2 s
const char *const kAr1 = "ar1";

toliman_period_noise search(const Series &series, const FrequencyGrid &grid, bool white, Progress &progress) {
    auto options = toliman::sized<toliman_period_noise_options>();
    options.flags = white ? TOLIMAN_PERIOD_WHITE_NOISE : 0;
    options.progress = Progress::callback;
    options.progress_data = &progress;
    const Nuisance &nuisance = series.nuisance;
    const std::vector<double> functions = nuisance.functions(series.t);
    auto found = toliman::sized<toliman_period_noise>();
    toliman::check(toliman_period_noise_search(grid.f0, grid.df, grid.nf, series.t.data(), series.y.data(),
                                               series.sigma.empty() ? nullptr : series.sigma.data(), series.t.size(),
                                               functions.data(),
                                               nuisance.precision.empty() ? nullptr : nuisance.precision.data(),
                                               nuisance.count(), &options, nullptr, nullptr, nullptr, &found));
    return found;
}

} // namespace

void add_noise(CLI::App &command, NoiseOptions &options) {
    command
        .add_option("--noise", options.model, "noise between samples: white (default), or ar1, correlated (see above)")
        ->check(CLI::IsMember({"white", kAr1}));
}

Noise::Noise(const NoiseOptions &options, const Series &series, const FrequencyGrid &grid, Progress &progress)
    : model_(options.model) {
    const bool white = model_ != kAr1;
    if (white && static_cast<double>(series.t.size()) * static_cast<double>(grid.nf) > kMostUnasked)
        return;
    try {
        found_ = search(series, grid, white, progress);
    } catch (const toliman::error &error) {
        const bool unsuited = error.status() == TOLIMAN_E_STATE || error.status() == TOLIMAN_E_ARGUMENT;
        if (unsuited && !white)
            malformed(series.name, std::string("--noise ar1: ") + error.what());
        if (!unsuited)
            throw;
    }
}

void Noise::warn(Progress &progress) const {
    if (found_ && model_ != kAr1 && found_->log10_p_white < kNotWhite)
        progress.warn(
            formatted("values are correlated (whiteness: log10 p = %.3g): false alarm probabilities for white "
                      "noise are too small: --noise ar1",
                      found_->log10_p_white));
}

void Noise::print() const {
    if (!found_ || model_ != kAr1)
        return;
    const toliman_period_noise &found = *found_;
    std::printf("noise       ar1: correlation %.3f +- %.2g over %.6g, white with log10 p = %.3g\n", found.rho,
                found.rho_error, found.step, found.log10_p_white);
    std::printf("with ar1    period %s, amplitude %s, power %.6f, log10 FAP %.3f (baluev)\n",
                text_with_error(found.period, found.period_error).c_str(),
                text_with_error(found.amplitude, found.amplitude_error).c_str(), found.power, found.log10_fap);
}

Json Noise::json() const {
    const toliman_period_noise &found = *found_;
    Json json("model", model_, "log10_p_white", found.log10_p_white);
    if (model_ != kAr1)
        return json;
    json.set("rho", found.rho);
    json.set("rho_error", found.rho_error);
    json.set("step", found.step);
    json.set("tau", found.tau);
    json.set("peak",
             Json("frequency", found.frequency, "frequency_error", found.frequency_error, "period", found.period,
                  "period_error", found.period_error, "power", found.power, "log10_residual", found.log10_residual,
                  "amplitude", found.amplitude, "amplitude_error", found.amplitude_error, "offset", found.offset,
                  "log10_fap", found.log10_fap, "at_edge", (found.flags & TOLIMAN_PERIOD_AT_EDGE) != 0));
    return json;
}

} // namespace cli
