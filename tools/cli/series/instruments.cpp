#include "series/instruments.hpp"

#include "base/constants.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

void add_sinusoid(const Series &series, double frequency, toliman_measure *measure) {
    std::vector<double> cosine, sine;
    for (const double t : series.t) {
        cosine.push_back(std::cos(2 * toliman::kPi * frequency * (t - series.t.front())));
        sine.push_back(std::sin(2 * toliman::kPi * frequency * (t - series.t.front())));
    }
    toliman::check(toliman_measure_add_column(measure, "cosine of the peak", cosine.data(), cosine.size(), 0));
    toliman::check(toliman_measure_add_column(measure, "sine of the peak", sine.data(), sine.size(), 0));
}

} // namespace

Instruments instruments_of(const Series &series, double frequency) {
    if (series.instruments.size() < 2)
        return {};
    const toliman::measurements measure = measure_of(series, 0, 0);
    if (frequency > 0 && series.nuisance.count() + 2 <= kMostFunctions)
        add_sinusoid(series, frequency, measure.get());
    Instruments all(series.instruments.size(), toliman::sized<toliman_measure_instrument>());
    size_t count = 0;
    const toliman_status status = toliman_measure_query_instruments(measure.get(), all.data(), all.size(), &count);
    if (status == TOLIMAN_E_STATE || status == TOLIMAN_E_ARGUMENT)
        malformed(series.name, toliman::error(status).what());
    toliman::check(status);
    return all;
}

void add_jitters(const Instruments &instruments, Series &series) {
    if (instruments.empty())
        return;
    const bool is_weighted = !series.sigma.empty();
    series.sigma.resize(series.t.size(), 0);
    for (size_t i = 0; i < series.t.size(); i++) {
        const toliman_measure_instrument &own = instruments[static_cast<size_t>(series.instrument[i])];
        if (!is_weighted || own.goodness == TOLIMAN_GOODNESS_POOR)
            series.sigma[i] = std::hypot(series.sigma[i], own.jitter[1]);
    }
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
