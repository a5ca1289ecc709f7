#include "downlink/ledger_report.hpp"

#include <array>

#include "common/content.hpp"
#include "downlink/folder_facts.hpp"
#include "downlink/instrument_trends.hpp"
#include "downlink/state_folder.hpp"
#include "series/fap.hpp"
#include "series/period_report.hpp"
#include "series/periodogram.hpp"

namespace cli {

namespace {

constexpr size_t kChunk = 4096; // records read or printed at once

// Prints a text for each record, many at once.
template <class Each> void print_each(const toliman::tracker &tracker, Each each) {
    std::string text;
    size_t count = 0;
    each_record(tracker, [&](const toliman_track_record &record) {
        each(record, text);
        if (++count % kChunk == 0)
            print_stdout(std::exchange(text, {}));
    });
    print_stdout(text);
}

// The columns of a reduction, for each record in turn.
class Reductions {
  public:
    explicit Reductions(const toliman::tracker &tracker)
        : tracker_(tracker), is_reduced_(info_of(tracker).system != nullptr) {}
    // Those of the next record, null without a number; nothing if the frames of the folder are not reduced.
    std::optional<Json> next() {
        const size_t row = static_cast<size_t>(next_++) % kChunk;
        if (!is_reduced_)
            return std::nullopt;
        Json json;
        for (size_t i = 0; i < kNames.size(); i++) {
            if (row == 0)
                columns_[i] = column_of(tracker_, kNames[i], next_ - 1, kChunk);
            json.set(kNames[i], Exact{columns_[i][row]});
        }
        return json;
    }

  private:
    static constexpr std::array<const char *, 3> kNames = {"separation_px", "factor", "geometric_arcsec"};

    const toliman::tracker &tracker_;
    bool is_reduced_;
    int64_t next_ = 0; // number of the record
    std::array<std::vector<double>, kNames.size()> columns_;
};

bool is_known(const toliman_track_record &line) noexcept {
    return line.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED || line.verdict == TOLIMAN_TRACK_VERDICT_OUTLIER ||
           line.verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED || line.verdict == TOLIMAN_TRACK_VERDICT_MISFIT ||
           line.verdict == TOLIMAN_TRACK_VERDICT_QUARANTINED;
}

Json session_json(const toliman_track_stream &stream) {
    return Json("session", stream.session, "roi", stream.roi, "restarts", stream.restarts, "first_id", stream.first_id,
                "last_id", stream.last_id, "frames", stream.frames, "missing", stream.missing);
}

void write_periodogram(OutputFile &out, const toliman_track_options &how, const std::vector<double> &power) {
    const std::vector<double> frequencies = frequencies_of({how.grid.f0, how.grid.df, how.grid.nf});
    write_csv(out, kStatePeriodogramMark, {{"frequency", &frequencies}, {"power", &power}});
}

// Power of the series without the fitted sinusoid, with the same functions.
std::vector<double> residual_power(const toliman_measure *series, const toliman_period_peak &fit,
                                   const toliman_track_options &how) {
    const toliman::measurements rest = without({fit.amplitude, fit.frequency, fit.phase, 0}, series);
    const Samples samples(rest.get());
    const std::vector<double> rows = column_rows(rest.get());
    auto options = toliman::sized<toliman_period_batch_options>();
    options.flags = how.grid.flags & TOLIMAN_PERIOD_FIXED_MEAN;
    set_functions(rest.get(), options);
    options.rows = rows.data();
    std::vector<double> power(static_cast<size_t>(how.grid.nf));
    toliman::check(toliman_period_batch(how.grid.f0, how.grid.df, how.grid.nf, samples.t.data(), samples.y.data(),
                                        samples.sigmas(), samples.count(), &options, power.data()));
    return power;
}

} // namespace

std::vector<toliman_track_record> records_of(const toliman::tracker &tracker, int64_t first, size_t count) {
    std::vector<toliman_track_record> records(count, toliman::sized<toliman_track_record>());
    if (count > 0)
        toliman::check(toliman_track_get_records(tracker.get(), first, count, records.data(), &count));
    records.resize(count);
    return records;
}

void each_record(const toliman::tracker &tracker, const std::function<void(const toliman_track_record &)> &each) {
    size_t done = kChunk;
    for (int64_t first = 0; done == kChunk; first += static_cast<int64_t>(kChunk)) {
        const std::vector<toliman_track_record> records = records_of(tracker, first, kChunk);
        done = records.size();
        std::for_each(records.begin(), records.end(), each);
    }
}

std::vector<double> column_of(const toliman::tracker &tracker, const std::string &name, int64_t first, size_t count) {
    std::vector<double> values(count);
    toliman::check(toliman_track_get_column(tracker.get(), name.c_str(), first, count, values.data(), &count));
    values.resize(count);
    return values;
}

std::vector<toliman_track_stream> streams_of(const toliman::tracker &tracker) {
    auto streams = all_of<toliman_track_stream>([&](toliman_track_stream *items, size_t capacity, size_t *count) {
        return toliman_track_get_streams(tracker.get(), items, capacity, count);
    });
    for (toliman_track_stream &stream : streams)
        if (stream.session[0] == '\0')
            std::snprintf(stream.session, sizeof stream.session, "#%016llx",
                          static_cast<unsigned long long>(stream.stream));
    return streams;
}

void print_records(const toliman::tracker &tracker) {
    std::map<uint64_t, toliman_track_stream> names;
    for (const toliman_track_stream &stream : streams_of(tracker))
        names[stream.stream] = stream;
    Reductions reductions(tracker);
    print_each(tracker, [&](const toliman_track_record &line, std::string &text) {
        const std::optional<Json> reduction = reductions.next();
        const bool is_frame =
            line.verdict != TOLIMAN_TRACK_VERDICT_MERGED && line.verdict != TOLIMAN_TRACK_VERDICT_INTERVALS;
        const bool is_valid = is_frame && line.verdict != TOLIMAN_TRACK_VERDICT_REJECTED;
        if (!is_frame)
            return;
        const bool is_named = names.count(line.stream) > 0;
        const toliman_track_stream stream = is_named ? names.at(line.stream) : toliman_track_stream{};
        Json json("schema", "toliman-record/1", "session", if_known(is_named, stream.session), "roi",
                  if_known(is_named, stream.roi), "restarts", if_known(is_named, stream.restarts), "frame_id",
                  line.frame_id, "camera_ns", line.camera_ns, "verdict", toliman_constant_name(line.verdict));
        if (!is_valid || line.verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED)
            json.set("reason", toliman_constant_name(line.reason));
        if (is_valid)
            json.set("tai_ns", line.tai_ns, "value", Exact{line.value}, "sigma", Exact{line.sigma}, "chi_square",
                     line.chi_square, "chi_square_sigma", line.chi_square_sigma, "largest_residual",
                     line.largest_residual, "goodness", toliman_constant_name(line.goodness), "bad_pixels",
                     line.bad_pixels);
        json.set("dropped", line.dropped);
        if (is_valid && reduction)
            json.set("reduction", *reduction);
        text += json.line();
    });
}

void print_series(const toliman::tracker &tracker, const toliman_track_options &how) {
    print_stdout("t,y,sigma\n");
    print_each(tracker, [&](const toliman_track_record &line, std::string &text) {
        if (line.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED)
            text += formatted("%.17g,%.17g,%.17g\n", time_of(line.tai_ns, how), line.value, line.sigma);
    });
}

void print_missing(const toliman::tracker &tracker) {
    std::map<uint64_t, std::vector<int64_t>> ids;
    each_record(tracker, [&](const toliman_track_record &line) {
        if (is_known(line))
            ids[line.stream].push_back(line.frame_id);
    });
    print_stdout("session,roi,first,last,restarts\n");
    for (const toliman_track_stream &stream : streams_of(tracker)) {
        std::vector<int64_t> &known = ids[stream.stream];
        std::sort(known.begin(), known.end());
        std::string text;
        for (size_t i = 1; i < known.size(); i++)
            if (known[i] > known[i - 1] && known[i] - 1 > known[i - 1])
                text += std::string(stream.session) + "," + stream.roi + "," + std::to_string(known[i - 1] + 1) + "," +
                        std::to_string(known[i] - 1) + "," + std::to_string(stream.restarts) + "\n";
        print_stdout(text);
    }
}

std::optional<double> median_sigma(const toliman::tracker &tracker) {
    std::vector<double> sigmas;
    each_record(tracker, [&](const toliman_track_record &line) {
        if (line.verdict == TOLIMAN_TRACK_VERDICT_ACCEPTED || line.verdict == TOLIMAN_TRACK_VERDICT_UNREDUCED)
            sigmas.push_back(line.sigma);
    });
    if (sigmas.empty())
        return std::nullopt;
    const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
    std::nth_element(sigmas.begin(), middle, sigmas.end());
    return *middle;
}

Json status_json(const toliman::tracker &tracker, const toliman_track_options &how, const PeriodFacts &period) {
    const toliman_track_info info = info_of(tracker);
    Json json("schema", "toliman-track-status/2", "folder", how.folder);
    period.add_to(json);
    add_counts(tracker, json);
    json.set("records", info.records, "sigma", median_sigma(tracker), "grid",
             Json("f0", how.grid.f0, "df", how.grid.df, "nf", how.grid.nf, "time_offset_ns", how.grid.time_offset_ns),
             "plate_scale_arcsec", if_known(info.system != nullptr, info.plate_scale_arcsec), "clock",
             how.clock.count > 0, "streams", array_of(streams_of(tracker), session_json), "goodness",
             goodness_json(goodness_of(tracker)), "trends", json_of(trends_of(tracker)));
    add_timing(how, json);
    return json;
}

void write_results(const toliman::tracker &tracker, const toliman_track_options &how, const PeriodFacts &period,
                   const std::string &path) {
    OutputFolder folder(path, {"result.json"});
    const bool has_frames = info_of(tracker).accepted > 0;
    const toliman::measurements series =
        has_frames ? accepted_frames(tracker, TOLIMAN_SERIES_PLAIN_TIMES) : series_of(how.folder, {}, {});
    const Samples samples(series.get());
    std::vector<Column> columns = {{"t", &samples.t}, {"y", &samples.y}, {"sigma", &samples.sigma}};
    std::vector<double> model;
    if (!period.fitted().all.empty()) {
        model = nuisance_values(series.get(), period.fitted().all);
        columns.push_back({"nuisance", &model});
    }
    write_csv(folder.open("series.csv"), kSeriesMark, columns);
    if (period.fit() && std::isfinite(period.fit()->amplitude_error))
        write_periodogram(folder.open("residual_periodogram.csv"), how,
                          residual_power(series.get(), *period.fit(), how));
    const std::vector<FrameColumn> frames = frames_over_time(tracker);
    if (!frames.empty()) {
        columns.clear();
        for (const FrameColumn &column : frames)
            columns.push_back({column.name, &column.values});
        write_csv(folder.open("frames.csv"), kSeriesMark, columns);
    }
    const toliman_period *sums = nullptr;
    toliman::check(toliman_track_get_period(tracker.get(), &sums));
    write_periodogram(folder.open("periodogram.csv"), how, power_of(sums, how.grid.nf));
    folder.open("result.json")
        .write(Json("schema", "toliman-state/1", "version", toliman_version(), "provenance", provenance(), "unit_s",
                    how.grid.unit_ns * 1e-9, "power_at_fap_1e-3", power_at_fap_1e_3(sums), "status",
                    status_json(tracker, how, period))
                   .text());
    folder.commit("result.json"); // a result.json implies that the other files are complete
}

} // namespace cli
