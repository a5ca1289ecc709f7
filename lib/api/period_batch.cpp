// include/toliman/period_batch.h
#include <toliman/period.h>
#include <toliman/period_batch.h>

#include "api/common.hpp"
#include "period/batch/batch.hpp"

using namespace toliman;
using namespace toliman::api;

extern "C" {

toliman_status toliman_period_batch(double f0, double df, int64_t nf, const double *t, const double *y,
                                    const double *sigma, size_t n, const toliman_period_batch_options *options,
                                    double *power) noexcept {
    return guard([&] {
        const auto known = accept(options, "options");
        required_array(t, n, sizeof *t, "t");
        required_array(y, n, sizeof *y, "y");
        required(power, "power");
        period::BatchJob job;
        job.grid.f0 = f0;
        job.grid.df = df;
        job.grid.nf = nf;
        job.grid.fixed_mean = (known.flags & TOLIMAN_PERIOD_FIXED_MEAN) != 0;
        TOLIMAN_COPY(job.grid.basis, known, trend, columns);
        job.grid.basis.start = known.trend_start;
        job.grid.basis.end = known.trend_end;
        std::copy_n(known.prior_precision, job.grid.basis.precision.size(), job.grid.basis.precision.begin());
        if (sigma == nullptr && job.grid.basis.has_priors())
            fail(Status::argument,
                 "{sigma}: must be given with prior_precision, whose unit is that of absolute sigmas");
        job.tolerance = (known.flags & TOLIMAN_PERIOD_DIRECT) != 0 ? 0 : known.tolerance;
        job.threads = known.threads;
        job.progress = {known.progress, known.progress_data};
        period::batch_power(job, {t, y, sigma, n, known.rows}, power);
    });
}

} // extern "C"
