// include/toliman/series.h
#include <toliman/series.h>

#include "api/common.hpp"
#include "api/series_options.hpp"
#include "api/times.hpp"
#include "base/progress.hpp"
#include "base/words.hpp"
#include "ingest/fields.hpp"
#include "ingest/series.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_series : Handle<toliman_series> {
    static constexpr char kType[] = "toliman_series";
    ingest::Series series;
    Log log;
    bool warned = false; // of marks of missing values
};

namespace {

void warn(toliman_series &series) {
    for (const std::string &warning : series.series.take_warnings())
        series.log.warn("%s", warning.c_str());
    const std::string mark = series.warned ? "" : series.series.marks().found();
    series.warned = series.warned || !mark.empty();
    if (!mark.empty())
        series.log.warn("%s: it may stand for a missing value", mark.c_str());
}

std::vector<std::string> columns_of(const char *text) {
    if (text == nullptr)
        return {};
    const bool with_commas = std::strchr(text, ',') != nullptr; // then a name may contain spaces
    std::vector<std::string> columns = with_commas ? ingest::split(text, ',') : words_of(text);
    const bool named = std::find(columns.begin(), columns.end(), "") == columns.end();
    if (columns.size() < 2 || columns.size() > 3 || !named)
        fail(Status::argument, "{options->columns} = \"%.60s\": must be a list of two or three names", text);
    return columns;
}

} // namespace

ingest::SeriesOptions toliman::api::series_options(const toliman_series_options &options) {
    const bool plain = (options.flags & TOLIMAN_SERIES_PLAIN_TIMES) != 0;
    if (plain && options.time_format != 0)
        fail(Status::argument, "{options->time_format} = %d: must be 0 with TOLIMAN_SERIES_PLAIN_TIMES",
             options.time_format);
    ingest::SeriesOptions known;
    known.name = options.name != nullptr ? options.name : "";
    known.columns = columns_of(options.columns);
    known.instrument = options.instrument != nullptr ? options.instrument : "";
    known.growing = (options.flags & TOLIMAN_SERIES_GROWING) != 0;
    known.times.plain = plain;
    if (options.time_format != 0)
        known.times.format = kFormats.to_enum(options.time_format);
    if (options.time_scale != 0)
        known.times.scale = kScales.to_enum(options.time_scale);
    known.times.leap_seconds =
        leap_seconds_of(options.leap_seconds, options.leap_second_count, "options->leap_seconds");
    return known;
}

extern "C" {

toliman_status toliman_series_create(const toliman_series_options *options, toliman_series **out) noexcept {
    return guard([&] {
        toliman_series *&made = required(out, "out");
        const auto known = accept(options, "options");
        made = new toliman_series{{}, ingest::Series(series_options(known)), Log{known.log, known.log_data}};
    });
}

void toliman_series_destroy(toliman_series *series) noexcept {
    destroy(series);
}

toliman_status toliman_series_parse(toliman_series *series, const char *line, size_t length,
                                    toliman_series_sample *sample) noexcept {
    return call(series, "series", [&](auto &self) {
        required_array(line, length, 1, "line");
        check_struct_size("sample", required(sample, "sample"));
        toliman_series_sample result = {};
        result.instrument = -1;
        if (const std::optional<ingest::Sample> found = self.series.parse({line, length}))
            result = {0, 1, found->t, found->y, found->sigma, found->instrument};
        deliver(result, sample, "sample");
        warn(self);
    });
}

toliman_status toliman_series_get_info(const toliman_series *series, toliman_series_info *out) noexcept {
    return query(series, "series", out, [&](auto &self, auto &info) {
        const ingest::Series &from = self.series;
        if (const std::optional<ingest::TimeFormat> format = from.format()) {
            info.time_format = kFormats.to_constant(*format);
            info.time_scale = kScales.to_constant(from.scale());
        }
        info.truncated = from.truncated() ? 1 : 0;
        info.lines = from.lines();
        info.missing = from.missing();
        info.instruments = static_cast<int64_t>(from.instruments().size());
        put_text(from.unit().name, info.unit_name);
        put_text(from.likely_instrument(), info.likely_instrument);
    });
}

} // extern "C"
