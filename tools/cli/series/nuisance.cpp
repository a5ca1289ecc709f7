#include "series/nuisance.hpp"

namespace cli {

std::vector<Function> functions_of(const toliman_measure *series) {
    return items_of(toliman_measure_get_function, series, info_of(series).functions);
}

std::vector<Function> columns_of(const toliman_measure *series) {
    std::vector<Function> functions = functions_of(series);
    functions.erase(functions.begin(), functions.begin() + info_of(series).trend);
    return functions;
}

std::vector<double> column_rows(const toliman_measure *series) {
    const std::vector<Function> columns = columns_of(series);
    std::vector<double> rows(static_cast<size_t>(info_of(series).n) * columns.size());
    for (size_t c = 0; c < columns.size(); c++) {
        const std::vector<double> values = values_of(series, columns[c].name);
        for (size_t i = 0; i < values.size(); i++)
            rows[i * columns.size() + c] = values[i];
    }
    return rows;
}

Coefficients coefficients_at(const toliman_period *period, int64_t k, const std::vector<Function> &columns) {
    const auto info = toliman::result<toliman_period_info>(toliman_period_get_info, period);
    if (info.trend + info.columns == 0)
        return {{}, info.functions, info.free_functions};
    const auto order = static_cast<size_t>(info.trend), count = 1 + order + static_cast<size_t>(info.columns);
    std::vector<double> values(count), errors(count);
    toliman::check(toliman_period_query_coefficients(period, k, count, values.data(), errors.data()));
    std::vector<Coefficient> all;
    for (size_t i = 0; i < count; i++) {
        const Function *const column = i > order && !columns.empty() ? &columns[i - 1 - order] : nullptr;
        const double unit = column != nullptr ? column->unit : 1, precision = info.prior_precision[i];
        all.push_back({column != nullptr ? column->name
                       : i == 0          ? "mean"
                       : i <= order      ? "T" + std::to_string(i)
                                         : "column " + std::to_string(i - order),
                       values[i] * unit, errors[i] * unit, precision > 0 ? 1 / std::sqrt(precision) * unit : 0, unit});
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

Json json_of(const Coefficients &coefficients) {
    return Json("in_use", coefficients.functions, "free", coefficients.free, "coefficients",
                array_of(coefficients.all, [](const Coefficient &one) {
                    return Json("name", one.name, "value", one.value, "error", one.error, "prior_sigma",
                                if_known(one.prior > 0, one.prior));
                }));
}

} // namespace cli
