// Method: T_0 = 1, T_1 = x, T_j+1 = 2 x T_j - T_j-1, with x from -1 at the start of the span to 1 at its end.
#include "series/nuisance.hpp"

#include <algorithm>
#include <utility>

namespace cli {

std::vector<double> Nuisance::row(size_t sample) const {
    std::vector<double> row;
    for (const NuisanceColumn &column : columns)
        row.push_back(column.values[sample]);
    return row;
}

std::vector<double> Nuisance::rows() const {
    std::vector<double> rows;
    for (size_t i = 0; !columns.empty() && i < columns[0].values.size(); i++)
        for (const NuisanceColumn &column : columns)
            rows.push_back(column.values[i]);
    return rows;
}

std::vector<double> Nuisance::functions(const std::vector<double> &t) const {
    std::vector<double> functions;
    functions.reserve(t.size() * count());
    for (size_t i = 0; i < t.size(); i++) {
        const double x = (2 * t[i] - trend.start - trend.end) / (trend.end - trend.start);
        double before = 1, now = x;
        for (int32_t j = 1; j <= trend.order; j++) {
            functions.push_back(now);
            before = std::exchange(now, 2 * x * now - before);
        }
        const std::vector<double> values = row(i);
        functions.insert(functions.end(), values.begin(), values.end());
    }
    return functions;
}

void Nuisance::set(toliman_period_options &options) const {
    options.trend = trend.order;
    options.trend_start = trend.start;
    options.trend_end = trend.end;
    options.columns = static_cast<int32_t>(columns.size());
    for (size_t c = 0; c < columns.size(); c++)
        options.column_bound[c] = columns[c].bound;
    std::copy(precision.begin(), precision.end(), options.prior_precision + 1);
}

std::vector<std::string> names_of_trend(int32_t order) {
    std::vector<std::string> names = {"mean"};
    for (int32_t j = 1; j <= order; j++)
        names.push_back("T" + std::to_string(j));
    return names;
}

} // namespace cli
