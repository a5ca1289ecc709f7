// include/toliman/period_noise.h
#include <toliman/period_noise.h>

#include "api/common.hpp"
#include "api/measure_handle.hpp"
#include "api/peak.hpp"
#include "measure/noise.hpp"
#include "period/noise/noise_bootstrap.hpp"
#include "period/noise/noise_search.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

toliman_period_noise public_noise(const period::NoiseModel &model, const measure::NoiseSeries &search,
                                  const period::NoiseResult &found, double offset, double offset_error) {
    const period::Cadence cadence = period::cadence_of(search.series().t);
    const period::NoiseSolution &solution = found.solution;
    const double f = found.frequency;
    toliman_period_noise out = {};
    const bool at_edge = f <= search.grid().f0 || f >= search.grid().last();
    out.flags = grid_flags(search.grid(), cadence) | (at_edge ? TOLIMAN_PERIOD_AT_EDGE : 0u) |
                (slow_flags(search.grid(), f, cadence.span) & TOLIMAN_PERIOD_LONG);
    TOLIMAN_COPY(out, found, rho, rho_error, log10_p_white, index, power, log10_residual, log10_fap, rank);
    out.tau = found.rho > 0 ? -cadence.step / std::log(found.rho) : 0;
    out.step = cadence.step;
    out.frequency = f;
    TOLIMAN_COPY(out, solution, frequency_error, amplitude, amplitude_error, phase, phase_error);
    out.period = 1 / f;
    out.period_error = solution.frequency_error / (f * f);
    out.offset = offset;
    out.offset_error = offset_error;
    out.time_reference = model.reference();
    return out;
}

} // namespace

extern "C" {

toliman_status toliman_measure_query_noise(const toliman_measure *series, double f0, double df, int64_t nf,
                                           const toliman_period_noise_options *options, double *power,
                                           double *coefficients, double *errors, toliman_period_noise *out) noexcept {
    return call(series, "series", [&](auto &self) {
        check_struct_size("out", required(out, "out"));
        const auto known = accept(options, "options");
        const measure::NoiseSeries search(f0, df, nf, self.series);
        period::NoiseModel model = search.model();
        const size_t count = 1 + self.series.functions();
        Buffer<double> powers(static_cast<size_t>(nf));
        std::vector<double> values(count), deviations(count);
        const period::NoiseResult found = period::search_noise(
            model, search.noise_grid(), (known.flags & TOLIMAN_PERIOD_WHITE_NOISE) != 0,
            {known.progress, known.progress_data}, powers.data(), values.data(), deviations.data());
        deliver(public_noise(model, search, found, values[0], deviations[0]), out, "out");
        values.erase(values.begin()); // of the mean
        deviations.erase(deviations.begin());
        copy_to(power, powers);
        copy_to(coefficients, values);
        copy_to(errors, deviations);
    });
}

toliman_status toliman_measure_query_noise_bootstrap(const toliman_measure *series, double f0, double df, int64_t nf,
                                                     double rho, const toliman_period_noise_bootstrap_options *options,
                                                     size_t count, double *log10_residuals) noexcept {
    return call(series, "series", [&](auto &self) {
        const auto known = accept(options, "options");
        required_array(&required(log10_residuals, "log10_residuals"), count, sizeof *log10_residuals,
                       "log10_residuals");
        if (!(rho >= 0 && rho <= period::kMaxRho))
            fail(Status::range, "{rho} = %g: must be in [0, %g]", rho, period::kMaxRho);
        if (known.block > self.series.count())
            fail(Status::range, "{options->block} = %llu: must be at most %zu, the number of samples",
                 static_cast<unsigned long long>(known.block), self.series.count());
        const measure::NoiseSeries search(f0, df, nf, self.series);
        period::NoiseModel model = search.model();
        model.set_rho(rho);
        model.check();
        std::vector<double> peaks(count);
        period::bootstrap_noise(
            model, search.noise_grid(),
            {known.seed, static_cast<size_t>(known.block), known.threads, {known.progress, known.progress_data}},
            peaks.data(), count);
        std::copy(peaks.begin(), peaks.end(), log10_residuals);
    });
}

} // extern "C"
