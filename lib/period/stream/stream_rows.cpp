// Samples of a periodogram with nuisance functions: checks, exact sums, sums of the functions at a frequency.
#include <cmath>

#include "base/error.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

bool Stream::is_in_span(const Sample &sample) const noexcept {
    constexpr double kRounding = 1 + 1e-12; // of times that are not doubles
    const Basis &basis = grid_.basis;
    return basis.trend == 0 ||
           std::fabs(static_cast<double>(position(basis, grid_.time_offset, sample.t_high, sample.t_low))) <= kRounding;
}

bool Stream::are_within_bounds(const double *columns) const noexcept {
    const Basis &basis = grid_.basis;
    for (size_t c = 0; c < static_cast<size_t>(basis.columns); c++)
        if (!(std::fabs(columns[c]) <= basis.bound[c]))
            return false;
    return true;
}

void Stream::check_basis(const Sample &sample, int64_t index) const {
    const auto where = [index] { return prefix_of_sample(index); };
    const Basis &basis = grid_.basis;
    if (!is_in_span(sample))
        fail(Status::range, "%s{t} = %.9g: must be in the span of the trend, [%.9g, %.9g], fixed at creation",
             where().c_str(), sample.t, basis.start, basis.end);
    if (basis.columns > 0 && sample.columns == nullptr)
        fail(Status::argument,
             "%s{rows}: the periodogram has %d columns: give their values, as to toliman_period_push_samples",
             where().c_str(), basis.columns);
    for (size_t c = 0; c < static_cast<size_t>(basis.columns); c++) {
        const double value = sample.columns[c];
        if (!std::isfinite(value))
            fail(Status::argument, "%s{rows}: column %zu = %g: must be finite", where().c_str(), c, value);
        if (!(std::fabs(value) <= basis.bound[c]))
            fail(Status::range, "%s{rows}: column %zu = %g: must be in [-%g, %g], column_bound, fixed at creation",
                 where().c_str(), c, value, basis.bound[c], basis.bound[c]);
    }
}

void Stream::add_row(const Sample &given, const kernels::PushSample &sample) noexcept {
    BasisValues values;
    evaluate(grid_.basis, grid_.time_offset, given.t_high, given.t_low, given.columns, values);
    basis_sums_.add(sample.weight, sample.value_high, sample.value_low, values);
    values.high[0] = sample.value_high; // the mean has no sums of its own: its place holds y
    values.low[0] = sample.value_low;
    int64_t *rows[kernels::kSums + (kMaxFunctions - 1) * kernels::kFunctionSums];
    for (size_t i = 0; i < grid_.sums(); i++)
        rows[i] = lo_.data() + i * padded();
    const kernels::PushRow row = {sample.t_high,           sample.t_low, sample.weight,
                                  grid_.basis.functions(), values.high,  values.low};
    kernels::push_rows_kernels().push(grid_.f0, grid_.df, blocks_, row, rows);
}

template <class Real> void Stream::function_sums(int64_t k, Real *c, Real *s) const noexcept {
    using namespace kernels;
    const auto both = [&](size_t sum, size_t low) {
        return sum_at<Real>(sum, k, kUnit) + sum_at<Real>(low, k, kLowUnit);
    };
    c[0] = both(kC1, kC1Low);
    s[0] = both(kS1, kS1Low);
    for (size_t f = 1; f < grid_.basis.functions(); f++) {
        const size_t first = kSums + (f - 1) * kFunctionSums;
        c[f] = both(first + kFunctionC, first + kFunctionCLow);
        s[f] = both(first + kFunctionS, first + kFunctionSLow);
    }
}
template void Stream::function_sums(int64_t, long double *, long double *) const noexcept;
#ifdef TOLIMAN_QUAD_IS_WIDER
template void Stream::function_sums(int64_t, Quad *, Quad *) const noexcept;
#endif

} // namespace toliman::period
