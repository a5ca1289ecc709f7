// include/toliman/period_nuisance.h
#include <algorithm>

#include <toliman/period_nuisance.h>

#include "api/guard.hpp"
#include "api/handles.hpp"
#include "api/peak.hpp"
#include "api/period_samples.hpp"
#include "period/stream/power.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

Structs structs(const toliman_period *period, const toliman_period_sample *samples, const double *rows, size_t n) {
    const Use use(period, "period");
    const auto width = static_cast<size_t>(use->stream.grid().basis.columns);
    if (width > 0)
        required_array(rows, checked_product(n, width, "rows"), sizeof *rows, "rows");
    return {samples, n, width > 0 ? rows : nullptr};
}

} // namespace

extern "C" {

toliman_status toliman_period_push_rows(toliman_period *period, const toliman_period_sample *samples,
                                        const double *rows, size_t n) noexcept {
    return guard([&] { push_all(period, structs(period, samples, rows, n)); });
}

toliman_status toliman_period_retract_rows(toliman_period *period, const toliman_period_sample *samples,
                                           const double *rows, size_t n) noexcept {
    return guard([&] { retract_all(period, structs(period, samples, rows, n)); });
}

toliman_status toliman_period_query_coefficients(const toliman_period *period, int64_t k, size_t count,
                                                 double *coefficients, double *errors) noexcept {
    return guard([&] {
        const Use use(period, "period");
        const period::Stream &stream = use->stream;
        const period::Basis &basis = stream.grid().basis;
        required(coefficients, "coefficients");
        if (!basis.any())
            fail(Status::state, "the periodogram has no trend, columns or priors");
        if (count != basis.functions())
            fail(Status::argument, "{count} = %zu: must be 1 + trend + columns = %zu", count, basis.functions());
        const period::PowerQuery query(stream);
        check_model(query, stream, k);
        const period::Coefficients found = query.coefficients(k);
        std::copy_n(found.value, count, coefficients);
        if (errors != nullptr)
            std::copy_n(found.error, count, errors);
    });
}

toliman_status toliman_period_query_fit_rows(const toliman_period *period, const double *t, const double *y,
                                             const double *sigma, const double *rows, size_t n,
                                             toliman_period_peak *out) noexcept {
    return guard([&] {
        const Use use(period, "period");
        const period::Stream &stream = use->stream;
        const period::Samples samples = {&required(t, "t"), &required(y, "y"), sigma, n, rows};
        required(out, "out");
        deliver(public_fit(stream, samples), out, "out");
    });
}

} // extern "C"
