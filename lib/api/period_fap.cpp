// include/toliman/period_fap.h
#include <toliman/period_fap.h>

#include "api/common.hpp"
#include "api/handles.hpp"
#include "period/bootstrap.hpp"
#include "period/fap.hpp"
#include "period/sampling.hpp"
#include "period/stream/power.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

period::Fap fap_method(int32_t method) {
    constexpr Choice<period::Fap> kFapMethods = {TOLIMAN_PERIOD_FAP_BALUEV, TOLIMAN_PERIOD_FAP_SEQUENTIAL,
                                                 "TOLIMAN_PERIOD_FAP_..."};
    return kFapMethods.to_enum(method, "method");
}

void check_meaningful(const period::Stream &stream) {
    period::check_meaningful(period::PowerQuery(stream), stream, "a false alarm probability");
}

} // namespace

extern "C" {

toliman_status toliman_period_query_fap(const toliman_period *period, int32_t method, double log10_residual,
                                        double *result) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        required(result, "log10_fap");
        const period::Fap fap = fap_method(method);
        if (!(log10_residual <= 0 && log10_residual >= period::kMinLogResidual))
            fail(Status::argument, "{log10_residual} = %g: must be in [%g, 0]", log10_residual,
                 period::kMinLogResidual);
        if (log10_residual == 0) { // P = 0 has FAP 1 for any samples, also for constant values
            *result = 0;
            return;
        }
        check_meaningful(stream);
        *result = log10_fap(fap, period::sampling_of(stream), log10_residual);
    });
}

toliman_status toliman_period_query_threshold(const toliman_period *period, int32_t method, double log10_fap,
                                              double *log10_residual) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        required(log10_residual, "log10_residual");
        const period::Fap fap = fap_method(method);
        check_meaningful(stream);
        const period::Sampling sampling = period::sampling_of(stream);
        const double least = period::log10_fap(fap, sampling, period::kMinLogResidual);
        if (!(log10_fap <= 0 && log10_fap >= least))
            fail(Status::argument, "{log10_fap} = %g: must be in [%g, 0] for these samples", log10_fap, least);
        *log10_residual = log10_threshold(fap, sampling, log10_fap);
    });
}

toliman_status toliman_period_query_bootstrap(const toliman_period *period, const double *t, const double *y,
                                              const double *sigma, size_t n,
                                              const toliman_period_bootstrap_options *options, size_t count,
                                              double *log10_residuals) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        const auto known = accept(options, "options");
        const period::Samples samples = {&required(t, "t"), &required(y, "y"), sigma, n, known.rows};
        required_array(&required(log10_residuals, "log10_residuals"), count, sizeof *log10_residuals,
                       "log10_residuals");
        check_meaningful(stream);
        std::vector<double> peaks(count);
        period::bootstrap(stream, samples, {known.seed, known.threads, {known.progress, known.progress_data}},
                          peaks.data(), count);
        std::copy(peaks.begin(), peaks.end(), log10_residuals);
    });
}

} // extern "C"
