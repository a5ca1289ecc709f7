// Format: JSON Lines; the first line has the arguments of the experiment, every other line one result, numbers with 17
// digits so that a resumed experiment has the same bits.
#include "experiment/journal.hpp"

#include <cmath>
#include <sstream>

#include "common/failure.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

// Calls work(key, member) for all members of a row, in the order of a line.
template <class AnyRow, class Work> void for_members(AnyRow &row, Work work) {
    work("table", row.table);
    work("method", row.method);
    work("amplitude_px", row.amplitude_px);
    work("seed", row.seed);
    work("series", row.series);
    work("period_days", row.period_days);
    work("log10_fap", row.log10_fap);
    work("slope", row.slope);
    work("sigma", row.sigma);
    work("mean", row.mean);
}

bool read_value(const cJSON *item, std::string &value) {
    value = cJSON_IsString(item) ? item->valuestring : "";
    return cJSON_IsString(item);
}

bool read_value(const cJSON *item, double &value) {
    value = cJSON_IsNumber(item) ? item->valuedouble : NAN;
    return cJSON_IsNumber(item) || cJSON_IsNull(item);
}

bool read_value(const cJSON *item, uint64_t &value) {
    const bool whole = cJSON_IsNumber(item) && item->valuedouble >= 0 && item->valuedouble < 9e15;
    value = whole ? static_cast<uint64_t>(item->valuedouble) : 0;
    return whole;
}

} // namespace

Journal::Journal(const std::string &path, const Json &arguments) : file_(path) {
    if (file_.text().empty()) {
        file_.begin(arguments.line());
        return;
    }
    std::istringstream lines(file_.text());
    std::string line;
    std::getline(lines, line);
    const JsonTree found(cJSON_ParseWithLength(line.data(), line.size()));
    if (!cJSON_IsObject(found.get()))
        malformed(path + ":1", "is not the journal of an experiment: give another --out");
    check_arguments(path, found.get(), arguments, "experiment");
    for (size_t number = 2; std::getline(lines, line); number++)
        rows_.insert(parse(line, number));
}

Row Journal::parse(const std::string &line, size_t number) const {
    const JsonTree found(cJSON_ParseWithLength(line.data(), line.size()));
    Row row;
    bool is_result = true;
    for_members(row, [&](const char *key, auto &value) {
        is_result = is_result && read_value(item_of(found.get(), key), value);
    });
    if (!is_result || std::isnan(row.amplitude_px))
        malformed(file_.path() + ":" + std::to_string(number),
                  "is not a result of an experiment: remove this line, and the result is computed again");
    return row;
}

void Journal::add(const Row &row) {
    Json line;
    for_members(row, [&](const char *key, const auto &value) {
        if constexpr (std::is_same_v<decltype(value), const double &>)
            line.set(key, Exact{value});
        else
            line.set(key, value);
    });
    file_.add(line.line());
    rows_.insert(row);
}

std::vector<Row> Journal::rows(const std::string &table, const std::string &method, double amplitude_px) const {
    return {rows_.lower_bound({table, method, amplitude_px}),
            rows_.upper_bound({table, method, amplitude_px, UINT64_MAX, UINT64_MAX})};
}

} // namespace cli
