// Method: Gram-Schmidt orthonormalisation, twice, of the weighted functions, in double and without a Gram matrix. A
// prior is one more sample, with a value in its function alone. Unlike lib/period/sample_basis.cpp, which serves one
// fit, this must not take longer than the FFT of the functions: Chebyshev polynomials in double on the span of the
// samples, where their condition is small. What is lost to a larger condition enters the error bound, and exact sums
// take over.
#include "period/batch/archive_basis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace toliman::period {

namespace {

constexpr double kRounding = 1e-15, kNegligible = 0x1p-40;

double dot(const Buffer<double> &w, const Buffer<double> &a, const Buffer<double> &b) noexcept {
    constexpr size_t kLanes = 8;
    double sums[kLanes] = {};
    size_t i = 0;
    for (; i + kLanes <= w.size(); i += kLanes)
        for (size_t j = 0; j < kLanes; j++)
            sums[j] += w[i + j] * a[i + j] * b[i + j];
    for (; i < w.size(); i++)
        sums[0] += w[i] * a[i] * b[i];
    double sum = 0;
    for (const double part : sums)
        sum += part;
    return sum;
}

void remove(double part, const Buffer<double> &from, Buffer<double> &out) noexcept {
    for (size_t i = 0; i < out.size(); i++)
        out[i] -= part * from[i];
}

void project(const Buffer<double> &w, const std::vector<Buffer<double>> &functions, Buffer<double> &out) noexcept {
    for (int pass = 0; pass < 2; pass++)
        for (const Buffer<double> &function : functions)
            remove(dot(w, function, out), function, out);
}

} // namespace

// The functions at the samples, as given.
static std::vector<Buffer<double>> columns_of(const Archive &archive, const Basis &basis) {
    std::vector<Buffer<double>> columns(basis.functions(), Buffer<double>(archive.n, 1.0));
    const double start = basis.start - archive.reference, end = basis.end - archive.reference;
    const double middle = 0.5 * (start + end), scale = basis.trend > 0 ? 2 / (end - start) : 0;
    for (size_t i = 0; i < archive.n; i++) {
        const double x = ((archive.t_high[i] - middle) + archive.t_low[i]) * scale;
        double before = 1, here = x;
        for (size_t f = 1; f < basis.first_column(); f++) {
            columns[f][i] = here;
            const double next = 2 * x * here - before;
            before = here;
            here = next;
        }
        const double *const row = archive.samples.columns + i * static_cast<size_t>(basis.columns);
        for (size_t f = basis.first_column(); f < basis.functions(); f++)
            columns[f][i] = row[f - basis.first_column()] / basis.unit(f);
    }
    return columns;
}

void complete(Basis &basis, const BatchSamples &samples) {
    const size_t n = samples.n;
    if (basis.trend > 0 && basis.start == basis.end && n > 0) {
        const auto [first, last] = std::minmax_element(samples.t, samples.t + n);
        basis.start = *first;
        basis.end = *last > *first ? *last : std::nextafter(*first, std::numeric_limits<double>::infinity());
    }
    for (size_t i = 0; i < n && basis.trend > 0; i++)
        if (!(samples.t[i] >= basis.start && samples.t[i] <= basis.end))
            fail(Status::range, "sample %zu: {t} = %.9g: must be in the span of the trend, [%.9g, %.9g]", i,
                 samples.t[i], basis.start, basis.end);
    const auto columns = static_cast<size_t>(std::clamp(basis.columns, 0, static_cast<int32_t>(kMaxColumns)));
    if (columns > 0 && n > 0 && samples.columns == nullptr)
        fail(Status::argument, "{options->rows}: must not be NULL with columns = %d", basis.columns);
    for (size_t c = 0; c < columns; c++) {
        for (size_t i = 0; i < n; i++) {
            const double value = samples.columns[i * columns + c];
            if (!std::isfinite(value))
                fail(Status::argument, "sample %zu: {rows}: column %zu = %g: must be finite", i, c, value);
            basis.bound[c] = std::max(basis.bound[c], std::fabs(value));
        }
        if (basis.bound[c] == 0)
            basis.bound[c] = 1;
    }
}

ArchiveBasis::ArchiveBasis(const Archive &archive, const Basis &basis) {
    std::vector<Buffer<double>> columns = columns_of(archive, basis);
    Buffer<double> weights = archive.w, values(archive.n);
    for (size_t i = 0; i < archive.n; i++)
        values[i] = archive.w[i] > 0 ? archive.x[i] / archive.w[i] : 0;
    for (size_t f = 0; f < columns.size(); f++) {
        if (!(basis.precision[f] > 0))
            continue;
        weights.push_back(1);
        values.push_back(0);
        for (Buffer<double> &column : columns)
            column.push_back(0);
        columns[f].back() = std::sqrt(basis.precision[f] * archive.unit_variance) / basis.unit(f);
        if (f == 0) // the mean was subtracted
            values.back() = -columns[f].back() * archive.mean_in_deviations;
    }
    double condition = 1;
    for (size_t f = 0; f < columns.size(); f++) {
        if (f < basis.first_column() && f > used()) // a lower order was left out
            continue;
        Buffer<double> &column = columns[f];
        const double whole = std::sqrt(dot(weights, column, column));
        project(weights, functions, column);
        const double norm = std::sqrt(dot(weights, column, column));
        if (!(norm > kNegligible * whole))
            continue;
        condition *= whole / norm;
        for (double &element : column)
            element /= norm;
        functions.push_back(std::move(column));
        free += basis.precision[f] > 0 ? 0 : 1;
    }
    project(weights, functions, values);
    const double spread = dot(weights, values, values);
    error = spread > 1e-20 ? kRounding * condition / std::sqrt(spread) : std::numeric_limits<double>::infinity();
    x.resize(archive.n);
    for (size_t i = 0; i < archive.n; i++) {
        x[i] = archive.w[i] * values[i] / std::sqrt(spread);
        largest_sum += std::fabs(x[i]);
    }
    for (Buffer<double> &function : functions) {
        function.resize(archive.n);
        for (size_t i = 0; i < archive.n; i++)
            function[i] *= archive.w[i];
    }
}

} // namespace toliman::period
