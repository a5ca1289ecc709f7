#include "series/nuisance.hpp"

#include <algorithm>

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
