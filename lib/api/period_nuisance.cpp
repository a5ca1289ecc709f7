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

extern "C" {

toliman_status toliman_period_query_coefficients(const toliman_period *period, int64_t k, size_t count,
                                                 double *coefficients, double *errors) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
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

} // extern "C"
