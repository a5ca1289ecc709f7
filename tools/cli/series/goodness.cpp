#include "series/goodness.hpp"

#include <toliman/goodness.h>

#include "base/constants.hpp"
#include "scenes/dates.hpp"
#include "series/nuisance.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

constexpr size_t kMost = 16, kShown = 4;

bool is_slow(const toliman_period_alias &alias) {
    return alias.slow != 0 && alias.equal != 0;
}

std::string interval_text(const toliman_period_alias &alias) {
    if (alias.interval_kind == TOLIMAN_PERIOD_INTERVAL_SAMPLING)
        return formatted("the sampling interval of %.6g", alias.interval);
    const std::string name = toliman_constant_name(alias.interval_kind);
    return alias.parts > 1 ? formatted("1/%d of one ", alias.parts) + name : "one " + name;
}

std::string line_of(const toliman_period_alias &alias) {
    const std::string at = " at " + interval_text(alias);
    if (alias.slow != 0)
        return "of a change slower than the grid," + at;
    return formatted("%.6g", alias.period) + at +
           (std::isnan(alias.power) ? ", outside the grid" : formatted(", power %.6f", alias.power));
}

constexpr size_t kListed = 10;

void add_sinusoid(double frequency, toliman_measure *series) {
    std::vector<double> cosine = values_of(series, "t"), sine = cosine;
    const double first = cosine.front();
    std::transform(sine.begin(), sine.end(), cosine.begin(),
                   [&](double t) { return std::cos(2 * toliman::kPi * frequency * (t - first)); });
    std::transform(sine.begin(), sine.end(), sine.begin(),
                   [&](double t) { return std::sin(2 * toliman::kPi * frequency * (t - first)); });
    toliman::check(toliman_measure_add_column(series, "cosine of the peak", cosine.data(), cosine.size(), 0));
    toliman::check(toliman_measure_add_column(series, "sine of the peak", sine.data(), sine.size(), 0));
}

} // namespace

std::string flags_text(uint32_t flags) {
    return std::string((flags & TOLIMAN_PERIOD_LONG) != 0 ? ", long period" : "") +
           ((flags & TOLIMAN_PERIOD_ANNUAL) != 0 ? ", annual" : "");
}

void set_flags(uint32_t flags, Json &json) {
    json.set("long_period", (flags & TOLIMAN_PERIOD_LONG) != 0, "annual", (flags & TOLIMAN_PERIOD_ANNUAL) != 0);
}

void warn_of_peak(uint32_t flags, const std::string &hint, bool is_dated, Progress &progress) {
    if ((flags & TOLIMAN_PERIOD_LONG) != 0)
        progress.warn("the period exceeds half the time span: a trend may cause it" + hint);
    if ((flags & TOLIMAN_PERIOD_ANNUAL) != 0)
        progress.warn(std::string(is_dated ? "" : "if t is in days, ") +
                      "the period is within one resolution of a year: the motion of the Earth, seasons and observing "
                      "windows may cause it");
}

Aliases aliases_of(const toliman_period *periodogram, double frequency) {
    const auto info = toliman::result<toliman_period_info>(toliman_period_get_info, periodogram);
    const double last = info.f0 + info.df * static_cast<double>(info.nf - 1);
    if (!(frequency >= info.f0 && frequency <= last))
        return {};
    Aliases aliases(kMost, toliman::sized<toliman_period_alias>());
    size_t count = 0;
    toliman::check(toliman_period_query_aliases(periodogram, frequency, aliases.data(), kMost, &count));
    aliases.resize(count);
    return aliases;
}

std::string text_of(const Aliases &aliases) {
    std::string text;
    size_t shown = 0;
    for (const toliman_period_alias &alias : aliases)
        if (alias.equal != 0 && shown++ < kShown)
            text += "alias       " + line_of(alias) + "\n";
    return text;
}

std::vector<Json> json_of(const Aliases &aliases) {
    return array_of(aliases, [](const toliman_period_alias &alias) {
        return Json("period", alias.period, "frequency", alias.frequency, "cause",
                    toliman_constant_name(alias.interval_kind), "interval", alias.interval, "window", alias.window,
                    "power", alias.power, "equal", alias.equal != 0, "slow", alias.slow != 0);
    });
}

void warn_of_aliases(const Aliases &aliases, const std::string &hint, Progress &progress) {
    const auto alias = std::find_if(aliases.begin(), aliases.end(), is_slow);
    if (alias != aliases.end())
        progress.warn("the period may be that of the sampling: a slow change, sampled at " + interval_text(*alias) +
                      ", has this peak as an alias" + hint);
}

std::string fit_text(double chi_square, double sigma, double largest, int32_t goodness) {
    return formatted("chi-square %.4g +- %.2g per degree of freedom: %s, largest residual %.4g sigma", chi_square,
                     sigma, toliman_constant_name(goodness), largest);
}

void warn_of_fit(double chi_square, double sigma, int32_t goodness, Progress &progress) {
    const std::string text = formatted("chi-square %.4g +- %.2g: ", chi_square, sigma);
    if (goodness == TOLIMAN_GOODNESS_POOR)
        progress.warn(text +
                      "poor: the sigmas are too small, or the model lacks an effect, or times, unit or axes are wrong");
    if (goodness == TOLIMAN_GOODNESS_TOO_GOOD)
        progress.warn(text + "too good: the sigmas are too large: are they in the unit of the values?");
}

void warn_of_outliers(size_t count, const std::string &cure, Progress &progress) {
    if (count > 0)
        progress.warn("outliers" + cure + formatted(": %zu", count));
}

std::string listed_outliers(const std::vector<int64_t> &indices, const toliman_measure *series) {
    const std::vector<double> times = values_of(series, "t");
    const bool is_dated = info_of(series).time_scale != 0;
    std::string text;
    for (size_t i = 0; i < std::min(indices.size(), kListed); i++) {
        const double t = times[static_cast<size_t>(indices[i])];
        text += (i == 0 ? "" : ", ") + (is_dated ? mjd_minute(t) : formatted("t = %.9g", t));
    }
    return text + (indices.size() > kListed ? ", ..." : "");
}

std::vector<Json> json_of_outliers(const std::vector<int64_t> &indices, const toliman_measure *series) {
    const std::vector<double> times = values_of(series, "t");
    return array_of(indices, [&](int64_t i) { return Json("index", i, "t", times[static_cast<size_t>(i)]); });
}

Instruments instruments_of(const toliman_measure *series, double frequency) {
    const toliman_measure_info info = info_of(series);
    if (info.instruments < 2)
        return {};
    const toliman::measurements fitted = changed(series, toliman::sized<toliman_measure_data>());
    if (frequency > 0 && info.functions + 2 <= static_cast<int64_t>(kMostFunctions))
        add_sinusoid(frequency, fitted.get());
    Instruments all(static_cast<size_t>(info.instruments), toliman::sized<toliman_measure_instrument>());
    size_t count = 0;
    const toliman_status status = toliman_measure_query_instruments(fitted.get(), all.data(), all.size(), &count);
    if (status == TOLIMAN_E_STATE || status == TOLIMAN_E_ARGUMENT)
        malformed(info.name, toliman::error(status).what());
    toliman::check(status);
    return all;
}

toliman::measurements with_jitters(const toliman_measure *series, const Instruments &instruments) {
    std::vector<double> sigmas = values_of(series, "sigma");
    const std::vector<double> which = values_of(series, "instrument");
    const bool is_weighted = !sigmas.empty();
    auto data = toliman::sized<toliman_measure_data>();
    if (!instruments.empty())
        sigmas.resize(which.size());
    for (size_t i = 0; i < which.size() && !instruments.empty(); i++) {
        const toliman_measure_instrument &own = instruments[static_cast<size_t>(which[i])];
        if (!is_weighted || own.goodness == TOLIMAN_GOODNESS_POOR)
            sigmas[i] = std::hypot(sigmas[i], own.jitter[1]);
    }
    data.sigma = sigmas.empty() ? nullptr : sigmas.data();
    return changed(series, data);
}

std::string text_of(const Instruments &instruments, const std::string &unit) {
    std::string text;
    const std::string in = unit.empty() ? "" : " " + unit;
    constexpr const char *kOf[] = {"", " of A", " of B"};
    for (const toliman_measure_instrument &one : instruments) {
        const bool is_first = !(one.offset_error > 0);
        text += formatted("instrument  %s%s: %lld samples", one.name[0] != '\0' ? one.name : "velocities",
                          kOf[one.source], static_cast<long long>(one.samples));
        text += is_first ? "" : formatted(", offset %.6g +- %.2g", one.offset, one.offset_error) + in;
        text += one.jitter[1] > 0 ? formatted(", jitter %.3g (-%.2g +%.2g)", one.jitter[1],
                                              one.jitter[1] - one.jitter[0], one.jitter[2] - one.jitter[1]) +
                                        in
                                  : "";
        text += std::isnan(one.chi_square) ? "\n" : formatted(", chi-square %.4g\n", one.chi_square);
    }
    return text;
}

std::vector<Json> json_of(const Instruments &instruments) {
    std::vector<Json> all;
    for (const toliman_measure_instrument &one : instruments)
        all.emplace_back("name", one.name, "source", one.source, "samples", one.samples, "offset", one.offset,
                         "offset_error", one.offset_error, "jitter", std::vector<double>(one.jitter, one.jitter + 3),
                         "chi_square", one.chi_square, "chi_square_sigma", one.chi_square_sigma, "goodness",
                         toliman_constant_name(one.goodness));
    return all;
}

} // namespace cli
