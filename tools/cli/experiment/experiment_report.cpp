#include "experiment/summary.hpp"

#include "common/content.hpp"
#include "common/provenance.hpp"
#include "common/text.hpp"
#include "experiment/methods.hpp"

namespace cli {

namespace {

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
    return Json("table", summary.table->name, "what", summary.table->what, "flux_ratio", info.flux_ratio, "crb_px",
                info.crb_px, "crb_projected_px", summary.crb_px, "crb_marginal_px", info.crb_marginal_px,
                "threshold_px", summary.threshold_px, "pca_threshold_px", summary.pca_threshold_px, "ladder",
                array_of(summary.ladder, ladder_json), "controls", array_of(summary.controls, control_json));
}

void print_ladder(std::string &out, const Campaign &campaign, const TableSummary &summary) {
    out += formatted("\n## Table %s: %s\n\n", summary.table->name.c_str(), summary.table->what.c_str());
    const toliman_sim_info &info = summary.table->frames->info;
    out += formatted(
        "Flux ratio %.3g. Cramer-Rao bound of a frame %.4g px (all nuisances free %.3g px). A method at the "
        "bound is expected to\nreach FAP = 1e-3 at %.3g px. The signal is the first principal component of "
        "whitened frames above %.3g px.\n\n",
        info.flux_ratio, summary.crb_px, info.crb_marginal_px, summary.threshold_px, summary.pca_threshold_px);
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

const Control *control_of(const TableSummary &summary, const std::string &method) {
    for (const Control &control : summary.controls)
        if (control.method == method)
            return &control;
    return nullptr;
}

// The tables with a single amplitude as one table: each has a few rows, with the scene's own signal.
void print_robust(std::string &out, const Campaign &campaign, const std::vector<TableSummary> &summaries) {
    std::string lines;
    for (const TableSummary &summary : summaries) {
        if (summary.table->ladder)
            continue;
        for (const LadderRow &row : summary.ladder) {
            const Control *control = control_of(summary, row.method);
            lines += formatted("| %s | %s | %.3g | ", summary.table->what.c_str(), row.method.c_str(), summary.crb_px);
            lines += control == nullptr ? "| | | "
                                        : formatted("%.2g | %.3g | %.4f | %.3f ", control->bias_px, control->sigma_px,
                                                    control->slope, control->efficiency);
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

} // namespace

std::string report_json(const Campaign &campaign, const std::vector<TableSummary> &summaries) {
    const toliman_sim_info &info = campaign.scene().info;
    const auto method_json = [](const std::string &name) {
        return Json("method", name, "what", method_kind(name).what);
    };
    const CampaignOptions &options = campaign.options();
    const FrequencyGrid &grid = campaign.grid();
    return Json("schema", "toliman-experiment/1", "version", toliman_version(), "provenance", provenance(), "scene",
                toliman_sim_get_name(campaign.scene().sim.get()), "frames", info.frames, "true_period_days",
                info.period_days, "amplitude_px", info.amplitude_px, "seeds", options.seeds, "blind", options.blind,
                "grid", Json("f0", grid.f0, "df", grid.df, "nf", grid.nf), "methods",
                array_of(options.methods, method_json), "tables", array_of(summaries, table_json))
        .text();
}

std::string report_markdown(const Campaign &campaign, const std::vector<TableSummary> &summaries) {
    const toliman_sim_info &info = campaign.scene().info;
    std::string out = formatted("# Experiment: %s\n\n", toliman_sim_get_name(campaign.scene().sim.get()));
    out += formatted(
        "%lld frames of %lldx%lld, period %g days, seeds 1 to %llu.%sbelow %g and the period\nwithin 5 %%.\n",
        static_cast<long long>(info.frames), static_cast<long long>(info.rows), static_cast<long long>(info.cols),
        info.period_days, static_cast<unsigned long long>(campaign.options().seeds), kExperimentMark, kFound);
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

} // namespace cli
