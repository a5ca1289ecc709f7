// What `toliman track` keeps: series, periodogram, what became of the frames.
#include <algorithm>
#include <cmath>

#include "common/text.hpp"
#include "downlink/ledger_report.hpp"
#include "downlink/state_folder.hpp"
#include "report/curves.hpp"
#include "report/glossary.hpp"
#include "report/sections.hpp"
#include "report/words.hpp"
#include "series/fap.hpp"
#include "series/periodogram.hpp"

namespace cli {

namespace {

constexpr size_t kMostDots = 4000, kCurve = 800;
constexpr double kDay = 86400e9; // ns

std::string unit_of(double unit_ns) {
    return unit_ns == kDay ? "days" : printed("units of %g s", unit_ns * 1e-9);
}

const std::vector<Word> kWords = {
    kFapWord,
    {"sequential FAP", "the same for who looks after every frame: how often noise alone has such a peak at any number "
                       "of frames"},
    kFwhmWord,
    {"outliers",
     "good frames whose value is beyond the limit, or whose time is beyond the grid: not in the periodogram"},
    {"quarantined", "a frame that came twice with other bytes: neither is trusted"},
};

struct Samples {
    Numbers t, y;
};

Samples samples_of(const toliman::tracker &tracker, const toliman_track_options &how) {
    Samples samples;
    for_lines(tracker, [&](const toliman_track_record &line) {
        if (line.verdict != TOLIMAN_TRACK_VERDICT_ACCEPTED)
            return;
        samples.t.push_back(time_of(line, how.time_offset_ns, how.unit_ns));
        samples.y.push_back(line.value);
    });
    return samples;
}

// What fits best, along the axis.
Means sinusoid(const toliman_period_peak &fit, const TimeAxis &axis, double start) {
    Means curve;
    const double from = axis.folded ? start : 0; // where the axis counts from
    for (size_t i = 0; i <= kCurve; i++) {
        const double x = axis.first + (axis.last - axis.first) * static_cast<double>(i) / kCurve;
        curve.x.push_back(x);
        curve.y.push_back(fit.offset + fit.amplitude * std::sin(2 * M_PI * (from + x) / fit.period + fit.phase));
    }
    return curve;
}

void add_series(const Samples &samples, const toliman_period_peak &fit, const std::string &unit, Page &page) {
    const TimeAxis axis = time_axis(samples.t, fit.log10_fap <= kSignificant ? fit.period : INFINITY, 0);
    const Numbers x = thinned(axis.x, kMostDots), y = thinned(samples.y, kMostDots);
    const ShortUnit px = short_unit(y, "px");
    Figure figure = {"series", "The value of each frame that is in the periodogram", 380, "", {}};
    figure.script = data_block("dots", {&x, &y}) + stacked(0, 1, figure) + "set key horizontal top right\nset xlabel " +
                    gnuplot_text(axis.folded ? "phase, " + unit + " of the best period" : "time, " + unit) +
                    "\nset ylabel " + gnuplot_text("separation, " + px.name) + "\nset offsets 0, 0, graph 0.12, 0\n" +
                    (axis.folded ? printed("set xrange [0:%.10g]\n", axis.last) : "") +
                    printed("plot $dots using 1:($2*%g) with points", px.factor) +
                    " pt 7 ps 0.3 lc rgb '#7fa3c7' title 'frames'";
    if (std::isfinite(fit.period) && std::isfinite(fit.amplitude_error)) {
        const Means curve = sinusoid(fit, axis, *std::min_element(samples.t.begin(), samples.t.end()));
        figure.script = data_block("best", {&curve.x, &curve.y}) + figure.script +
                        printed(", $best using 1:($2*%g) with lines lw 2 lc rgb '%s' title 'best sinusoid'", px.factor,
                                line_colour(1));
        figure.caption += ", and the sinusoid that fits all best: amplitude " + scientific(fit.amplitude) +
                          " &plusmn; " + scientific(fit.amplitude_error, 2) + " px, period " +
                          with_error(fit.period, fit.period_error) + " " + unit;
        if (axis.folded)
            figure.caption += ", into one of which all are folded";
    }
    figure.caption += "." + thinning_remark(samples.t.size(), kMostDots);
    figure.script += "\n";
    page.add(std::move(figure));
}

// Power of FAP 1e-3; NaN where there are too few samples.
double level_of(const toliman_period *period) {
    double log10_residual = 0;
    const bool known =
        toliman_period_query_threshold(period, TOLIMAN_PERIOD_FAP_BALUEV, -3, &log10_residual) == TOLIMAN_OK;
    return known ? 1 - std::pow(10, log10_residual) : NAN;
}

// The fit where there is one, else the grid's.
const toliman_period_peak &best_of(const PeriodFacts &facts) {
    return std::isfinite(facts.fit().period) ? facts.fit() : facts.peak();
}

void add_periodogram(const toliman::tracker &tracker, const toliman_track_options &how, const PeriodFacts &facts,
                     const std::string &unit, Page &page) {
    const toliman_period *sums = nullptr;
    toliman::check(toliman_track_get_period(tracker.get(), &sums));
    PowerCurve curve;
    curve.name = "all frames";
    curve.power.resize(static_cast<size_t>(how.nf));
    toliman::check(
        toliman_period_query_power(sums, TOLIMAN_PERIOD_POWER_STANDARD, 0, curve.power.size(), curve.power.data()));
    for (size_t k = 0; k < curve.power.size(); k++)
        curve.frequency.push_back(how.f0 + how.df * static_cast<double>(k));
    const toliman_period_peak &peak = facts.peak();
    const auto text_of = [&](double period) {
        return fixed(period, decimals_of(facts.fit().period_error)) + " " + unit;
    };
    curve.peak_frequency = 1 / best_of(facts).period;
    curve.fwhm = peak.fwhm;
    curve.level = level_of(sums);
    curve.peak_label = text_of(best_of(facts).period);
    add_power_figure(
        "periodogram",
        "Lomb-Scargle power on the grid of the folder, whose highest power lies at a period of " +
            text_of(peak.period) +
            " (grid peak). The dashed line is for one look; for who looks after every frame the sequential FAP "
            "holds.",
        unit == "days" ? "1/day" : "1/unit of time", {curve}, page);
}

std::string facts_text(const PeriodFacts &facts, const std::string &unit) {
    if (!std::isfinite(facts.peak().log10_fap))
        return "no period yet";
    const toliman_period_peak &best = best_of(facts);
    return "period " + with_error(best.period, best.period_error) + " " + unit + ", log<sub>10</sub> FAP " +
           fixed(best.log10_fap, 2) + "; sequential, for who looks after every frame, " + fixed(facts.sequential(), 2);
}

void add_counts_table(const toliman::tracker &tracker, Page &page) {
    const toliman_track_info info = info_of(tracker);
    const auto row = [](const std::string &name, int64_t count) {
        return std::vector<std::string>{name, std::to_string(count)};
    };
    std::vector<std::vector<std::string>> rows = {row("received", info.received), row("accepted", info.accepted),
                                                  row("outliers", info.outlier),  row("quarantined", info.quarantined),
                                                  row("repeated", info.repeated), row("rejected", info.rejected)};
    for (const auto &[reason, frames] : rejected_of(tracker))
        if (frames > 0)
            rows.push_back(row("&nbsp;&nbsp;" + reason, frames));
    rows.insert(rows.end(), {row("expected", info.expected), row("missing", info.missing),
                             row("dropped by the camera", info.dropped), row("sessions and regions", info.sessions)});
    page.add_table("Frames by what became of them. Of rejected ones every arrival counts.", {"", "frames"}, rows);
}

} // namespace

void add_state_section(const std::string &folder, Page &page, Progress &progress) {
    toliman_track_options how = state_to_read(folder);
    const toliman::tracker tracker = open_tracker(how, progress);
    const PeriodFacts facts(tracker, Fit::made);
    const Samples samples = samples_of(tracker, how);
    const std::string unit = unit_of(how.unit_ns);
    progress.show("report: state", 0.3);
    page.add_title("toliman track: " + escaped(folder));
    page.add_text("All frames so far: " + facts_text(facts, unit) + ".");
    add_counts_table(tracker, page);
    if (samples.t.size() > 1)
        add_series(samples, facts.fit(), unit, page);
    if (std::isfinite(facts.peak().period))
        add_periodogram(tracker, how, facts, unit, page);
    page.explain(kWords);
}

} // namespace cli
