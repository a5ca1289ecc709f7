#include "series/nuisance.hpp"

namespace cli {

namespace {

double sigma_of(double precision) {
    return precision > 0 ? 1 / std::sqrt(precision) : 0;
}

// Without their numbers.
std::vector<Coefficient> named(const toliman_period_info &info, const std::vector<NuisanceColumn> &columns) {
    std::vector<Coefficient> all;
    for (const std::string &name : names_of_trend(info.trend))
        all.push_back({name, 0, 0, 0, 1});
    for (size_t c = 0; c < static_cast<size_t>(info.columns); c++)
        all.push_back({c < columns.size() ? columns[c].name : "column " + std::to_string(c + 1), 0, 0, 0,
                       c < columns.size() ? columns[c].unit : 1});
    for (size_t i = 0; i < all.size(); i++)
        all[i].prior = sigma_of(info.prior_precision[i]) * all[i].unit;
    return all;
}

} // namespace

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

Coefficients coefficients_at(const toliman_period *period, int64_t k, const std::vector<NuisanceColumn> &columns) {
    const auto info = toliman::result<toliman_period_info>(toliman_period_get_info, period);
    if (info.trend + info.columns == 0)
        return {{}, info.functions, info.free_functions};
    std::vector<Coefficient> all = named(info, columns);
    std::vector<double> values(all.size()), errors(all.size());
    toliman::check(toliman_period_query_coefficients(period, k, all.size(), values.data(), errors.data()));
    for (size_t i = 0; i < all.size(); i++) {
        all[i].value = values[i] * all[i].unit;
        all[i].error = errors[i] * all[i].unit;
    }
    return {std::move(all), info.functions, info.free_functions};
}

std::string text_of(const Coefficients &coefficients) {
    std::string text = formatted("functions   %d in use, %d free\n", coefficients.functions, coefficients.free);
    for (const Coefficient &one : coefficients.all)
        text += formatted("  %-17s %s%s\n", one.name.c_str(),
                          std::isinf(one.error) ? "not in use" : text_with_error(one.value, one.error).c_str(),
                          one.prior > 0 ? formatted(", prior +- %.4g", one.prior).c_str() : "");
    return text;
}

void print(const Coefficients &coefficients) {
    std::printf("%s", text_of(coefficients).c_str());
}

Json json_of(const Coefficients &coefficients) {
    return Json("in_use", coefficients.functions, "free", coefficients.free, "coefficients",
                array_of(coefficients.all, [](const Coefficient &one) {
                    return Json("name", one.name, "value", one.value, "error", one.error, "prior_sigma",
                                if_known(one.prior > 0, one.prior));
                }));
}

} // namespace cli
