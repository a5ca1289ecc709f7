// Method: Chebyshev polynomials by their recurrence T_{j+1} = 2 x T_j - T_{j-1} in 113 bits, rounded to pairs of
// doubles. On a declared span, because the functions must not change as samples arrive; Chebyshev polynomials, because
// their Gram matrix has the smallest condition of those tried (monomials in [-1, 1] lose a factor of 5, in [0, 1] of
// 18, in days all digits from K = 6).
// Pairs, because samples that cover 3 % of the span see only 1e-8 of T_5 that the lower orders do not describe: rounded
// to double, that would have 8 digits.
#include "period/stream/basis.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace toliman::period {

namespace {

// Adds a b c with a b = high + low, an unevaluated sum, as is c = c_high + c_low.
void add_triple(ExactSum &sum, double high, double low, double c_high, double c_low) noexcept {
    sum.add_product(high, c_high);
    sum.add_product(high, c_low);
    sum.add_product(low, c_high);
}

void split(Quad x, double &high, double &low) noexcept {
    high = static_cast<double>(x);
    low = static_cast<double>(x - static_cast<Quad>(high));
}

bool within(Quad product, Quad a, Quad b, Quad slack) noexcept {
    return product * product <= (a + slack) * (b + slack);
}

} // namespace

void Basis::check() const {
    constexpr auto kMost = static_cast<int32_t>(kMaxColumns);
    if (trend < 0 || trend > kMaxTrend)
        fail(Status::argument, "{trend} = %d: must be in [0, %d]", trend, kMaxTrend);
    if (columns < 0 || columns > kMost - trend)
        fail(Status::argument, "{columns} = %d: must be in [0, %d] with trend = %d", columns, kMost - trend, trend);
    if (trend == 0 && !(start == 0 && end == 0))
        fail(Status::argument, "{trend_start} = %g, trend_end = %g: must be 0 without a trend", start, end);
    if (trend > 0 && !(std::isfinite(start) && std::isfinite(end) && start < end && std::isfinite(end - start)))
        fail(Status::argument, "{trend_start} = %g, trend_end = %g: must be finite, the start before the end", start,
             end);
    for (size_t c = 0; c < kMaxColumns; c++) {
        if (c >= static_cast<size_t>(columns) && bound[c] != 0)
            fail(Status::argument, "{column_bound[%zu]} = %g: must be 0 with columns = %d", c, bound[c], columns);
        if (c < static_cast<size_t>(columns) && !(bound[c] >= 1e-100 && bound[c] <= 1e100))
            fail(Status::argument, "{column_bound[%zu]} = %g: must be in [1e-100, 1e100]", c, bound[c]);
    }
    for (size_t f = 0; f < kMaxFunctions; f++) {
        if (f >= functions() && precision[f] != 0)
            fail(Status::argument, "{prior_precision[%zu]} = %g: must be 0 with %zu functions", f, precision[f],
                 functions());
        if (!(precision[f] == 0 || (precision[f] >= 1e-200 && precision[f] <= 1e200)))
            fail(Status::argument, "{prior_precision[%zu]} = %g: must be 0 or in [1e-200, 1e200]", f, precision[f]);
    }
}

void Basis::save(ByteWriter &out) const {
    out.f64(start);
    out.f64(end);
    for (size_t c = 0; c < static_cast<size_t>(columns); c++)
        out.f64(bound[c]);
    for (size_t f = 0; f < functions(); f++)
        out.f64(precision[f]);
}

void Basis::load(ByteReader &in) {
    start = in.f64();
    end = in.f64();
    for (size_t c = 0; c < static_cast<size_t>(columns); c++)
        bound[c] = in.f64();
    for (size_t f = 0; f < functions(); f++)
        precision[f] = in.f64();
}

Quad position(const Basis &basis, double offset, double high, double low) noexcept {
    const Quad start = static_cast<Quad>(basis.start) - static_cast<Quad>(offset),
               end = static_cast<Quad>(basis.end) - static_cast<Quad>(offset);
    return (2 * (static_cast<Quad>(high) + static_cast<Quad>(low)) - (start + end)) / (end - start);
}

void evaluate(const Basis &basis, double offset, double high, double low, const double *columns,
              BasisValues &values) noexcept {
    const size_t first = basis.first_column();
    if (first > 1) {
        const Quad x = position(basis, offset, high, low);
        Quad before = 1, here = x;
        for (size_t j = 1; j < first; j++) {
            split(here, values.high[j], values.low[j]);
            const Quad next = 2 * x * here - before;
            before = here;
            here = next;
        }
    }
    for (size_t f = first; f < basis.functions(); f++) {
        const double given = columns[f - first], bound = basis.unit(f);
        values.high[f] = given / bound;
        values.low[f] = std::fma(-values.high[f], bound, given) / bound;
    }
}

BasisSums::BasisSums(size_t functions) : functions_(functions), sums_(count(functions)) {}

void BasisSums::add(double weight, double y_high, double y_low, const BasisValues &values) noexcept {
    for (size_t i = 1; i < functions_; i++) {
        ExactSum *const sums = sums_.data() + row(i);
        const double high = weight * values.high[i];
        const double low = std::fma(weight, values.high[i], -high) + weight * values.low[i];
        sums[0].add(high);
        sums[0].add(low);
        for (size_t j = 1; j <= i; j++)
            add_triple(sums[j], high, low, values.high[j], values.low[j]);
        add_triple(sums[i + 1], high, low, y_high, y_low);
    }
}

void BasisSums::add(const BasisSums &other) noexcept {
    for (size_t i = 0; i < sums_.size(); i++)
        sums_[i].add(other.sums_[i]);
}

void BasisSums::reset() noexcept {
    std::fill(sums_.begin(), sums_.end(), ExactSum());
}

bool BasisSums::consistent(Quad weight, Quad wyy, Quad slack) const noexcept {
    for (size_t i = 1; i < functions_; i++) {
        const Quad square = product(i, i).value();
        if (!(square >= -slack && square <= weight + slack && within(product(i, 0).value(), square, weight, slack) &&
              within(with_y(i).value(), square, wyy, slack)))
            return false;
        for (size_t j = 1; j < i; j++)
            if (!within(product(i, j).value(), square, product(j, j).value(), slack))
                return false;
    }
    return true;
}

} // namespace toliman::period
