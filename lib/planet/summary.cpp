// Method: each sample of the posterior is a row of numbers. Intervals are the 16, 50 and 84 % points of a column,
// correlations those of Pearson. Periastron and epoch are periodic: each is moved to within half a period of the best
// fit's, as samples on both sides of 0 would otherwise give an interval of nearly a whole period.
#include "planet/summary.hpp"

#include <algorithm>
#include <cmath>

#include "planet/instruments.hpp"
#include "planet/orientation.hpp"

namespace toliman::planet {

namespace {

Interval interval_of_column(const std::vector<Row> &rows, size_t column) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const Row &row : rows)
        values.push_back(row[column]);
    return std::isnan(values[0]) ? Interval{NAN, NAN, NAN} : interval_of(std::move(values));
}

void set_correlation(const std::vector<Row> &rows, double *out) {
    constexpr size_t count = kDescribed;
    const auto n = static_cast<double>(rows.size());
    double mean[count] = {}, sums[count][count] = {};
    for (const Row &row : rows)
        for (size_t i = 0; i < count; i++)
            mean[i] += row[i] / n;
    for (const Row &row : rows)
        for (size_t i = 0; i < count; i++)
            for (size_t j = 0; j < count; j++)
                sums[i][j] += (row[i] - mean[i]) * (row[j] - mean[j]);
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < count; j++)
            out[i * count + j] = i == j ? 1 : sums[i][j] / std::sqrt(std::max(sums[i][i] * sums[j][j], 1e-300));
}

} // namespace

Row row_of(const Result &result, const Candidate &candidate, const PosteriorSample &sample) {
    const Description own = describe(sample.planet), &best = candidate.best;
    const Series &series = result.series;
    const Orientation orientation = orientation_of(series, sample.planet);
    const auto mass = [&](int star) {
        const bool may_have = !series.has_velocities() || sample.planet.orbit.star == star;
        return may_have ? result.settings.units.mass(star, own[0], own[1], orientation.axis) : NAN;
    };
    return {own[0],
            own[1],
            best[2] + std::remainder(own[2] - best[2], 360),
            series.time_reference + best[3] + std::remainder(own[3] - best[3], own[0]),
            own[4],
            mass(0),
            mass(1),
            sample.jitter,
            orientation.inclination_deg,
            orientation.node_deg};
}

Summary summary_of(const Result &result, const Candidate &candidate) {
    std::vector<Row> rows;
    rows.reserve(candidate.samples.size());
    for (const PosteriorSample &sample : candidate.samples)
        rows.push_back(row_of(result, candidate, sample));
    Summary summary = {};
    for (size_t column = 0; column < kColumns; column++)
        summary.intervals[column] = interval_of_column(rows, column);
    set_correlation(rows, summary.correlation.data());
    return summary;
}

Interval jitter_of_series(const Result &result) {
    const Series &series = result.series;
    double largest = 0;
    for (size_t k = 0; k < series.groups.size(); k++)
        if (series.groups[k].source == 0)
            largest = std::max(largest, series.jitter_scales()[k]);
    Interval jitter = jitter_of(result.last_fitted().samples);
    for (double &point : jitter)
        point *= largest;
    return jitter;
}

std::vector<Interval> jitters_of(const Result &result) {
    const Interval common = jitter_of(result.last_fitted().samples);
    if (result.series.groups.size() == 1)
        return {common};
    return jitter_intervals(result.series, *result.design, common[1]);
}

} // namespace toliman::planet
