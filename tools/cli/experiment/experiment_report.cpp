#include "experiment/experiment_report.hpp"

#include <cmath>
#include <cstdarg>

#include "common/content.hpp"

namespace cli {

namespace {

__attribute__((format(printf, 1, 2))) std::string text(const char *format, ...) {
    char buffer[512];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(buffer, sizeof buffer, format, arguments);
    va_end(arguments);
    return buffer;
}

double count(size_t number) {
    return static_cast<double>(number);
}

Json json_of(const LadderRow &row) {
    Json json;
    json.set("method", row.method).set("amplitude_px", row.amplitude_px).set("seeds", count(row.seeds));
    json.set("found", count(row.found)).set("period_error", row.period_error).set("log10_fap", row.log10_fap);
    json.set("expected_log10_fap", row.expected_log10_fap).set("slope", row.slope);
    json.set("efficiency", row.efficiency);
    return json;
}

Json json_of(const Control &control) {
    Json json;
    json.set("method", control.method).set("series", count(control.series)).set("frames", count(control.frames));
    json.set("alarms", count(control.alarms)).set("ks_p", control.uniformity).set("sigma_px", control.sigma_px);
    json.set("efficiency", control.efficiency).set("bias_px", control.bias_px).set("slope", control.slope);
    return json;
}

Json json_of(const TableSummary &summary);

template <class Item> JsonTree array_of(const std::vector<Item> &items) {
    JsonTree array(cJSON_CreateArray());
    for (const Item &item : items)
        cJSON_AddItemToArray(array.get(), json_of(item).release().release());
    return array;
}

Json json_of(const TableSummary &summary) {
    const toliman_sim_info &info = summary.table->frames->info;
    Json json;
    json.set("table", summary.table->name).set("what", summary.table->what).set("flux_ratio", info.flux_ratio);
    json.set("crb_px", info.crb_px).set("crb_projected_px", summary.crb_px);
    json.set("crb_marginal_px", info.crb_marginal_px).set("threshold_px", summary.threshold_px);
    json.set("pca_threshold_px", summary.pca_threshold_px);
    json.set("ladder", array_of(summary.ladder)).set("controls", array_of(summary.controls));
    return json;
}

void print_ladder(std::string &out, const Campaign &campaign, const TableSummary &summary) {
    out += text("\n## Table %s: %s\n\n", summary.table->name.c_str(), summary.table->what.c_str());
    const toliman_sim_info &info = summary.table->frames->info;
    out += text("Flux ratio %.3g. Cramer-Rao bound of a frame %.4g px (all nuisances free %.3g px). A method at the "
                "bound is expected to\nreach FAP = 1e-3 at %.3g px. The signal is the first principal component of "
                "whitened frames above %.3g px.\n\n",
                info.flux_ratio, summary.crb_px, info.crb_marginal_px, summary.threshold_px, summary.pca_threshold_px);
    out += "| amplitude, px | method | found | period error, % | log10 FAP | slope | efficiency |\n";
    out += "|---|---|---|---|---|---|---|\n";
    std::string last;
    for (const LadderRow &row : summary.ladder) {
        const std::string amplitude = text("%g", row.amplitude_px);
        if (amplitude != last)
            out += text("| %s | at the bound | | | %.1f | 1 | 1 |\n", amplitude.c_str(), row.expected_log10_fap);
        last = amplitude;
        out += text("| %s | %s | %zu of %zu | %.2g | %.1f |", amplitude.c_str(), row.method.c_str(), row.found,
                    row.seeds, 100 * row.period_error, row.log10_fap);
        const bool seen = 2 * row.found > row.seeds; // otherwise the slope is that of noise
        out += seen ? text(" %.3g | %.3g |\n", row.slope, row.efficiency) : " | |\n";
    }
    if (summary.controls.empty())
        return;
    out += text("\nSeries of %lld frames without signal:\n\n", static_cast<long long>(campaign.scene().info.frames));
    out += "| method | series | alarms at FAP 1e-3 | uniform, KS p | sigma, px | efficiency "
           "|\n|---|---|---|---|---|---|\n";
    for (const Control &control : summary.controls)
        out += text("| %s | %zu | %zu | %.2g | %.3g | %.3f |\n", control.method.c_str(), control.series, control.alarms,
                    control.uniformity, control.sigma_px, control.efficiency);
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
            lines += text("| %s | %s | %.3g | ", summary.table->what.c_str(), row.method.c_str(), summary.crb_px);
            lines += control == nullptr ? "| | | "
                                        : text("%.2g | %.3g | %.4f | %.3f ", control->bias_px, control->sigma_px,
                                               control->slope, control->efficiency);
            lines += text("| %zu of %zu | %.1f |\n", row.found, row.seeds, row.log10_fap);
        }
    }
    if (lines.empty())
        return;
    out += text(
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
    Json json, grid;
    grid.set("f0", campaign.grid().f0).set("df", campaign.grid().df).set("nf", static_cast<double>(campaign.grid().nf));
    json.set("schema", "toliman-experiment/1").set("version", toliman_version());
    json.set("scene", toliman_sim_get_name(campaign.scene().sim.get()));
    json.set("frames", static_cast<double>(info.frames)).set("true_period_days", info.period_days);
    json.set("amplitude_px", info.amplitude_px);
    json.set("seeds", static_cast<double>(campaign.options().seeds));
    json.set("blind", static_cast<double>(campaign.options().blind)).set("grid", std::move(grid));
    json.set("tables", array_of(summaries));
    return json.text();
}

std::string report_markdown(const Campaign &campaign, const std::vector<TableSummary> &summaries) {
    const toliman_sim_info &info = campaign.scene().info;
    std::string out = text("# Experiment: %s\n\n", toliman_sim_get_name(campaign.scene().sim.get()));
    out +=
        text("%lld frames of %lldx%lld, period %g days, seeds 1 to %llu.%sbelow %g and the period\nwithin 5 %%.\n",
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
                for (const Row &row : campaign.rows(journal, table, method, amplitude))
                    out += text("%s,%s,%.17g,%llu,%llu,%.17g,%.17g,%.17g,%d,%.17g,%.17g,%.17g,%.17g\n",
                                row.table.c_str(), row.method.c_str(), row.amplitude_px,
                                static_cast<unsigned long long>(row.seed), static_cast<unsigned long long>(row.series),
                                row.period_days, period_error(campaign, row), row.log10_fap,
                                found(campaign, row) ? 1 : 0, row.slope, row.sigma, row.mean, efficiency(table, row));
    }
    return out;
}

} // namespace cli
