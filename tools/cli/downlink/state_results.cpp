#include "downlink/state_results.hpp"

#include "common/content.hpp"
#include "common/output.hpp"
#include "common/provenance.hpp"
#include "downlink/ledger_report.hpp"
#include "series/fap.hpp"
#include "series/periodogram.hpp"

namespace cli {

namespace {

Json session_json(const toliman_track_stream &stream) {
    Json json;
    json.set("session", stream.session).set("roi", stream.roi);
    json.set("first_id", stream.first_id).set("last_id", stream.last_id);
    return std::move(json.set("frames", stream.frames).set("missing", stream.missing));
}

void write_periodogram(const toliman_period *sums, const toliman_track_options &how, OutputFile &out) {
    const std::vector<double> power = power_of(sums, how.nf);
    out.print("%sfrequency,power\n", kStatePeriodogramMark);
    for (size_t k = 0; k < power.size(); k++)
        out.print("%.17g,%.17g\n", how.f0 + how.df * static_cast<double>(k), power[k]);
}

} // namespace

Json status_json(const toliman::tracker &tracker, const toliman_track_options &how, const PeriodFacts &period) {
    const toliman_track_info info = info_of(tracker);
    Json json, grid;
    json.set("schema", "toliman-track-status/2").set("folder", how.folder);
    period.add_to(json);
    add_counts(tracker, json);
    json.set("records", info.records).set("sigma", info.sigma);
    grid.set("f0", how.f0).set("df", how.df).set("nf", how.nf).set("time_offset_ns", how.time_offset_ns);
    json.set("grid", std::move(grid)).set("clock", how.clock_points > 0);
    json.set("streams", array_of(streams_of(tracker), session_json));
    add_timing(how, json);
    return json;
}

void write_results(const toliman::tracker &tracker, const toliman_track_options &how, const std::string &path) {
    OutputFolder folder(path);
    OutputFile result(folder.file("result.json")), series(folder.file("series.csv")),
        periodogram(folder.file("periodogram.csv"));
    series.print("%s", kSeriesMark);
    print_series(tracker, how, [&](const std::string &text) { series.write(text.data(), text.size()); });
    const toliman_period *sums = nullptr;
    toliman::check(toliman_track_get_period(tracker.get(), &sums));
    write_periodogram(sums, how, periodogram);
    Json json;
    json.set("schema", "toliman-state/1").set("version", toliman_version()).set("provenance", provenance());
    json.set("unit_s", how.unit_ns * 1e-9).set("power_at_fap_1e-3", power_at_fap_1e_3(sums));
    const std::string text = json.set("status", status_json(tracker, how, PeriodFacts(tracker, Fit::made))).text();
    result.write(text.data(), text.size());
    series.commit();
    periodogram.commit();
    result.commit(); // last: a result.json implies that the other files are complete
    folder.keep();
}

} // namespace cli
