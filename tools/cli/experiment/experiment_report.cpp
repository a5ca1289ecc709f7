// Method: the injection table (`ladder` in the JSON) has, for each method and amplitude, medians over the seeds,
// since a lost period makes a mean meaningless. The controls (series without signal) have the number of false
// alarms, the uniformity of the FAPs, and the scatter: the variance of all series of a seed is pooled and divided
// by the squared slope, so that values in other units than px compare with the Cramer-Rao bound; the result is the
// median over the seeds.
#include "experiment/experiment_report.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/content.hpp"
#include "common/provenance.hpp"
#include "common/text.hpp"
#include "frames/frame_loop.hpp"

namespace cli {

namespace {

struct LadderRow { // a method at one amplitude
    std::string method;
    double amplitude_px = 0;
    size_t seeds = 0, found = 0;
    double period_error = 0, log10_fap = 0; // medians; relative
    double slope = 0, efficiency = 0;       // medians, by regression on the true displacement
    double expected_log10_fap = 0;          // of a method at the Cramer-Rao bound
};

struct Control { // a method on series without signal
    std::string method;
    size_t series = 0, frames = 0, alarms = 0;
    double uniformity = 0;               // p-value of the FAPs against the uniform distribution, Kolmogorov-Smirnov
    double sigma_px = 0, efficiency = 0; // medians over the seeds; sigma is divided by the slope
    double bias_px = 0, slope = 0;       // means
};

struct TableSummary {
    const Table *table = nullptr;
    double crb_px = 0, threshold_px = 0, pca_threshold_px = 0;
    std::vector<LadderRow> ladder;
    std::vector<Control> controls; // empty without series without signal
};

constexpr double kClose = 0.05; // largest relative error of a period that was found

// |period / true period - 1|.
double period_error(const Campaign &campaign, const Row &row) {
    return std::fabs(row.period_days / campaign.scene().info.period_days - 1);
}

// Whether the signal was found: log10 FAP below kFound, and the period within 5 % of the true one.
bool found(const Campaign &campaign, const Row &row) {
    return row.log10_fap < kFound && period_error(campaign, row) < kClose;
}

// Cramer-Rao bound over the scatter, both in px; 0 of a series without values.
double efficiency(const Table &table, const Row &row) {
    return row.sigma > 0 ? table.frames->bounds().crb_projected_px * std::fabs(row.slope) / row.sigma : 0;
}

template <class Value> std::vector<double> values_of(const std::vector<Row> &rows, Value value) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const Row &row : rows)
        values.push_back(value(row));
    return values;
}

LadderRow ladder_row_of(const Campaign &campaign, const Table &table, const std::vector<Row> &rows) {
    LadderRow result = {rows[0].method, rows[0].amplitude_px, rows.size()};
    for (const Row &row : rows)
        result.found += found(campaign, row) ? 1 : 0;
    result.period_error = median(values_of(rows, [&](const Row &row) { return period_error(campaign, row); }));
    result.log10_fap = median(values_of(rows, [](const Row &row) { return row.log10_fap; }));
    result.slope = median(values_of(rows, [](const Row &row) { return row.slope; }));
    result.efficiency = median(values_of(rows, [&](const Row &row) { return efficiency(table, row); }));
    result.expected_log10_fap =
        campaign.theory().log10_fap(result.amplitude_px, table.frames->bounds().crb_projected_px);
    return result;
}

// Scatter in px for each seed, pooled over its series.
std::vector<double> pooled_sigmas(const std::vector<Row> &rows) {
    std::map<uint64_t, std::vector<double>> squares;
    for (const Row &row : rows)
        squares[row.seed].push_back(row.sigma > 0 ? row.sigma * row.sigma / (row.slope * row.slope) : INFINITY);
    std::vector<double> sigmas;
    sigmas.reserve(squares.size());
    for (const auto &[seed, of_seed] : squares)
        sigmas.push_back(std::sqrt(mean(of_seed)));
    return sigmas;
}

Control control_of(const Campaign &campaign, const Table &table, const std::vector<Row> &rows) {
    Control control = {rows[0].method, rows.size(), rows.size() * static_cast<size_t>(campaign.scene().info.frames)};
    for (const Row &row : rows)
        control.alarms += row.log10_fap < kFound ? 1 : 0;
    control.uniformity = uniformity(values_of(rows, [](const Row &row) { return std::pow(10, row.log10_fap); }));
    control.sigma_px = median(pooled_sigmas(rows));
    control.efficiency = table.frames->bounds().crb_projected_px / control.sigma_px;
    control.bias_px = mean(values_of(rows, [](const Row &row) { return row.mean; }));
    control.slope = mean(values_of(rows, [](const Row &row) { return row.slope; }));
    return control;
}

std::vector<TableSummary> summarise(const Campaign &campaign, const Journal &journal) {
    std::vector<TableSummary> summaries;
    for (const Table &table : campaign.tables()) {
        TableSummary summary;
        summary.table = &table;
        summary.crb_px = table.frames->bounds().crb_projected_px;
        summary.threshold_px = campaign.theory().threshold_px(summary.crb_px);
        summary.pca_threshold_px =
            campaign.theory().pca_threshold_px(summary.crb_px, static_cast<double>(table.frames->pixels()));
        for (const double amplitude : table.amplitudes)
            for (const std::string &method : campaign.options().methods) {
                const std::vector<Row> rows = journal.rows(table.name, method, amplitude);
                if (!rows.empty())
                    summary.ladder.push_back(ladder_row_of(campaign, table, rows));
            }
        for (const std::string &method : campaign.options().methods) {
            const std::vector<Row> blind = journal.rows(table.name, method, 0);
            if (!blind.empty())
                summary.controls.push_back(control_of(campaign, table, blind));
        }
        summaries.push_back(std::move(summary));
    }
    return summaries;
}

Json ladder_json(const LadderRow &row) {
    return Json("method", row.method, "amplitude_px", row.amplitude_px, "seeds", row.seeds, "found", row.found,
                "period_error", row.period_error, "log10_fap", row.log10_fap, "expected_log10_fap",
                row.expected_log10_fap, "slope", row.slope, "efficiency", row.efficiency);
}

Json control_json(const Control &control) {
    return Json("method", control.method, "series", control.series, "frames", control.frames, "alarms", control.alarms,
                "ks_p", control.uniformity, "sigma_px", control.sigma_px, "efficiency", control.efficiency, "bias_px",
                control.bias_px, "slope", control.slope);
}

Json table_json(const TableSummary &summary) {
    const toliman_sim_info &info = summary.table->frames->info;
    const toliman_sim_bounds bounds = summary.table->frames->bounds();
    return Json("table", summary.table->name, "what", summary.table->what, "flux_ratio", info.flux_ratio, "crb_px",
                bounds.crb_px, "crb_projected_px", summary.crb_px, "crb_marginal_px", bounds.crb_marginal_px,
                "threshold_px", summary.threshold_px, "pca_threshold_px", summary.pca_threshold_px, "ladder",
                array_of(summary.ladder, ladder_json), "controls", array_of(summary.controls, control_json));
}

void print_ladder(std::string &out, const Campaign &campaign, const TableSummary &summary) {
    out += formatted("\n## Table %s: %s\n\n", summary.table->name.c_str(), summary.table->what.c_str());
    const toliman_sim_info &info = summary.table->frames->info;
    out +=
        formatted("Flux ratio %.3g. Cramer-Rao bound of a frame %.4g px (all nuisances free %.3g px). A method at the "
                  "bound is expected to\nreach FAP = 1e-3 at %.3g px. The signal is the first principal component of "
                  "whitened frames above %.3g px.\n\n",
                  info.flux_ratio, summary.crb_px, summary.table->frames->bounds().crb_marginal_px,
                  summary.threshold_px, summary.pca_threshold_px);
    out += "| amplitude, px | method | found | period error, % | log10 FAP | slope | efficiency |\n";
    out += "|---|---|---|---|---|---|---|\n";
    std::string last;
    for (const LadderRow &row : summary.ladder) {
        const std::string amplitude = formatted("%g", row.amplitude_px);
        if (amplitude != last)
            out += formatted("| %s | at the bound | | | %.1f | 1 | 1 |\n", amplitude.c_str(), row.expected_log10_fap);
        last = amplitude;
        out += formatted("| %s | %s | %zu of %zu | %.2g | %.1f |", amplitude.c_str(), row.method.c_str(), row.found,
                         row.seeds, 100 * row.period_error, row.log10_fap);
        const bool seen = 2 * row.found > row.seeds; // otherwise the slope is that of noise
        out += seen ? formatted(" %.3g | %.3g |\n", row.slope, row.efficiency) : " | |\n";
    }
    if (summary.controls.empty())
        return;
    out +=
        formatted("\nSeries of %lld frames without signal:\n\n", static_cast<long long>(campaign.scene().info.frames));
    out += "| method | series | alarms at FAP 1e-3 | uniform, KS p | sigma, px | efficiency "
           "|\n|---|---|---|---|---|---|\n";
    for (const Control &control : summary.controls)
        out += formatted("| %s | %zu | %zu | %.2g | %.3g | %.3f |\n", control.method.c_str(), control.series,
                         control.alarms, control.uniformity, control.sigma_px, control.efficiency);
}

// The tables with a single amplitude as one table: each has a few rows, with the scene's own signal.
void print_robust(std::string &out, const Campaign &campaign, const std::vector<TableSummary> &summaries) {
    std::string lines;
    for (const TableSummary &summary : summaries) {
        if (summary.table->ladder)
            continue;
        for (const LadderRow &row : summary.ladder) {
            const auto control = std::find_if(summary.controls.begin(), summary.controls.end(),
                                              [&](const Control &one) { return one.method == row.method; });
            lines += formatted("| %s | %s | %.3g | ", summary.table->what.c_str(), row.method.c_str(), summary.crb_px);
            lines += control == summary.controls.end()
                         ? "| | | "
                         : formatted("%.2g | %.3g | %.4f | %.3f ", control->bias_px, control->sigma_px, control->slope,
                                     control->efficiency);
            lines += formatted("| %zu of %zu | %.1f |\n", row.found, row.seeds, row.log10_fap);
        }
    }
    if (lines.empty())
        return;
    out += formatted(
        "\n## Table robust: frames of other scenes, methods of this scene\n\nThe scene's own signal of %g px, at most "
        "%zu seeds. Bias, sigma and efficiency are those of frames without signal, the slope\nis that of expected "
        "images. For frames relative to their own mean, their expected image is replaced by the reference\nimage of "
        "the methods' scene.\n\n",
        campaign.scene().info.amplitude_px, summaries.back().table->blind.size());
    out += "| frames | method | bound, px | bias, px | sigma, px | slope | efficiency | found | log10 FAP |\n"
           "|---|---|---|---|---|---|---|---|---|\n" +
           lines;
}

std::string report_json(const Campaign &campaign, const std::vector<TableSummary> &summaries) {
    const toliman_sim_info &info = campaign.scene().info;
    const auto method_json = [](const std::string &name) {
        return Json("method", name, "what", method_kind(name).what);
    };
    const CampaignOptions &options = campaign.options();
    const FrequencyGrid &grid = campaign.grid();
    return Json("schema", "toliman-experiment/1", "version", toliman_version(), "provenance", provenance(), "scene",
                campaign.scene().info.name, "frames", info.frames, "true_period_days", info.period_days, "amplitude_px",
                info.amplitude_px, "seeds", options.seeds, "controls", name_of(options.controls), "blind",
                options.blind, "grid", Json("f0", grid.f0, "df", grid.df, "nf", grid.nf), "methods",
                array_of(options.methods, method_json), "tables", array_of(summaries, table_json))
        .text();
}

std::string report_markdown(const Campaign &campaign, const std::vector<TableSummary> &summaries) {
    const toliman_sim_info &info = campaign.scene().info;
    std::string out = formatted("# Experiment: %s\n\n", campaign.scene().info.name);
    out += formatted(
        "%lld frames of %lldx%lld, period %g days, seeds 1 to %llu.%sbelow %g and the period\nwithin 5 %%.\n",
        static_cast<long long>(info.frames), static_cast<long long>(info.rows), static_cast<long long>(info.cols),
        info.period_days, static_cast<unsigned long long>(campaign.options().seeds), kExperimentMark, kFound);
    if (campaign.options().controls == Controls::none)
        out += "\nControls: none: no series without signal.\n";
    if (campaign.options().controls == Controls::quick)
        out += formatted("\nControls: quick: %llu series without signal per table.\n",
                         static_cast<unsigned long long>(campaign.options().blind));
    for (const TableSummary &summary : summaries)
        if (summary.table->ladder)
            print_ladder(out, campaign, summary);
    print_robust(out, campaign, summaries);
    return out;
}

std::string report_csv(const Campaign &campaign, const Journal &journal) {
    std::string out = kTrialsMark;
    out += "table,method,amplitude_px,seed,series,period_days,period_error,log10_fap,found,slope,sigma,mean,"
           "efficiency\n";
    for (const Table &table : campaign.tables()) {
        std::vector<double> amplitudes = table.amplitudes;
        amplitudes.push_back(0);
        for (const double amplitude : amplitudes)
            for (const std::string &method : campaign.options().methods)
                for (const Row &row : journal.rows(table.name, method, amplitude))
                    out += formatted("%s,%s,%.17g,%llu,%llu,%.17g,%.17g,%.17g,%d,%.17g,%.17g,%.17g,%.17g\n",
                                     row.table.c_str(), row.method.c_str(), row.amplitude_px,
                                     static_cast<unsigned long long>(row.seed),
                                     static_cast<unsigned long long>(row.series), row.period_days,
                                     period_error(campaign, row), row.log10_fap, found(campaign, row) ? 1 : 0,
                                     row.slope, row.sigma, row.mean, efficiency(table, row));
    }
    return out;
}

} // namespace

ExperimentReport report_of(const Campaign &campaign, const Journal &journal) {
    const std::vector<TableSummary> summaries = summarise(campaign, journal);
    return {report_json(campaign, summaries), report_markdown(campaign, summaries), report_csv(campaign, journal)};
}

} // namespace cli
