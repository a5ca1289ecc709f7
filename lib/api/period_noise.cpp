// include/toliman/period_noise.h
#include <algorithm>
#include <cmath>
#include <vector>

#include <toliman/period_noise.h>

#include "api/guard.hpp"
#include "api/peak.hpp"
#include "period/noise/noise_bootstrap.hpp"
#include "period/noise/noise_search.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

// The caller's series and grid.
struct Series {
    double f0, df;
    int64_t nf;
    const double *t, *y, *sigma;
    size_t n;
    const double *functions, *precision;
    size_t k;

    period::Grid grid() const {
        period::Grid grid;
        grid.f0 = f0;
        grid.df = df;
        grid.nf = nf;
        grid.sigma_ceiling = grid.sigma_floor;
        grid.check();
        return grid;
    }
    period::NoiseGrid noise_grid() const { return {f0, df, static_cast<size_t>(nf)}; }
    period::NoiseModel model() const {
        required_array(t, n, sizeof *t, "t");
        required_array(y, n, sizeof *y, "y");
        required_array(functions, checked_product(n, k, "functions"), sizeof *functions, "functions");
        return {{{t, y, sigma, n}, functions, k, precision}, grid().last()};
    }
};

toliman_period_noise public_noise(const period::NoiseModel &model, const Series &series,
                                  const period::NoiseResult &found, double offset, double offset_error) {
    const period::Cadence cadence = period::cadence_of({series.t, series.t + series.n});
    const period::NoiseSolution &solution = found.solution;
    const double f = found.frequency;
    toliman_period_noise out = {};
    const bool at_edge = f <= series.f0 || f >= series.grid().last();
    out.flags = grid_flags(series.grid(), cadence) | (at_edge ? TOLIMAN_PERIOD_AT_EDGE : 0u) |
                (slow_flags(series.grid(), f, cadence.span) & TOLIMAN_PERIOD_LONG);
    out.rho = found.rho;
    out.rho_error = found.rho_error;
    out.tau = found.rho > 0 ? -cadence.step / std::log(found.rho) : 0;
    out.step = cadence.step;
    out.log10_p_white = found.log10_p_white;
    out.index = static_cast<int64_t>(found.index);
    out.power = found.power;
    out.log10_residual = found.log10_residual;
    out.log10_fap = found.log10_fap;
    out.frequency = f;
    out.frequency_error = solution.frequency_error;
    out.period = 1 / f;
    out.period_error = solution.frequency_error / (f * f);
    out.amplitude = solution.amplitude;
    out.amplitude_error = solution.amplitude_error;
    out.phase = solution.phase;
    out.phase_error = solution.phase_error;
    out.offset = offset;
    out.offset_error = offset_error;
    out.time_reference = model.reference();
    out.rank = static_cast<uint32_t>(found.rank);
    return out;
}

} // namespace

extern "C" {

void toliman_period_noise_options_init(toliman_period_noise_options *options, size_t size) noexcept {
    deliver_defaults(toliman_period_noise_options{}, options, size);
}

toliman_status toliman_period_noise_search(double f0, double df, int64_t nf, const double *t, const double *y,
                                           const double *sigma, size_t n, const double *functions,
                                           const double *precision, size_t k,
                                           const toliman_period_noise_options *options, double *power,
                                           double *coefficients, double *errors, toliman_period_noise *out) noexcept {
    return guard([&] {
        check_struct_size("out", required(out, "out"));
        const auto known = accept(options, toliman_period_noise_options{}, "options");
        if ((known.flags & ~TOLIMAN_PERIOD_WHITE_NOISE) != 0)
            fail(Status::argument, "{options->flags} = 0x%x: unknown bits", known.flags);
        const Series series = {f0, df, nf, t, y, sigma, n, functions, precision, k};
        period::NoiseModel model = series.model();
        Buffer<double> powers(static_cast<size_t>(nf));
        std::vector<double> values(k + 1), deviations(k + 1);
        const period::NoiseResult found = period::search_noise(
            model, series.noise_grid(), (known.flags & TOLIMAN_PERIOD_WHITE_NOISE) != 0,
            {known.progress, known.progress_data}, powers.data(), values.data(), deviations.data());
        deliver(public_noise(model, series, found, values[0], deviations[0]), out, "out");
        if (power != nullptr)
            std::copy(powers.begin(), powers.end(), power);
        if (coefficients != nullptr)
            std::copy(values.begin() + 1, values.end(), coefficients);
        if (errors != nullptr)
            std::copy(deviations.begin() + 1, deviations.end(), errors);
    });
}

void toliman_period_noise_bootstrap_options_init(toliman_period_noise_bootstrap_options *options,
                                                 size_t size) noexcept {
    deliver_defaults(toliman_period_noise_bootstrap_options{}, options, size);
}

toliman_status toliman_period_noise_bootstrap(double f0, double df, int64_t nf, const double *t, const double *y,
                                              const double *sigma, size_t n, const double *functions,
                                              const double *precision, size_t k, double rho,
                                              const toliman_period_noise_bootstrap_options *options, size_t count,
                                              double *log10_residuals) noexcept {
    return guard([&] {
        const auto known = accept(options, toliman_period_noise_bootstrap_options{}, "options");
        required_array(&required(log10_residuals, "log10_residuals"), count, sizeof *log10_residuals,
                       "log10_residuals");
        if (!(rho >= 0 && rho <= period::kMaxRho))
            fail(Status::range, "{rho} = %g: must be in [0, %g]", rho, period::kMaxRho);
        if (known.block > n)
            fail(Status::range, "{options->block} = %llu: must be at most n, %zu",
                 static_cast<unsigned long long>(known.block), n);
        const Series series = {f0, df, nf, t, y, sigma, n, functions, precision, k};
        period::NoiseModel model = series.model();
        model.set_rho(rho);
        model.check();
        std::vector<double> peaks(count);
        period::bootstrap_noise(
            model, series.noise_grid(),
            {known.seed, static_cast<size_t>(known.block), known.threads, {known.progress, known.progress_data}},
            peaks.data(), count);
        std::copy(peaks.begin(), peaks.end(), log10_residuals);
    });
}

} // extern "C"
