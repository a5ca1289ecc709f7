// Method: the injection table (`ladder` in the JSON) has, for each method and amplitude, medians over the seeds,
// since a lost period makes a mean meaningless. The controls (series without signal) have the number of false
// alarms, the uniformity of the FAPs, and the scatter: the variance of all series of a seed is pooled and divided
// by the squared slope, so that values in other units than px compare with the Cramer-Rao bound; the result is the
// median over the seeds.
#include "experiment/summary.hpp"

#include <cmath>
#include <map>

#include "frames/frame_loop.hpp"

namespace cli {

namespace {

constexpr double kClose = 0.05; // largest relative error of a period that was found

template <class Value> std::vector<double> values_of(const std::vector<Row> &rows, Value value) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const Row &row : rows)
        values.push_back(value(row));
    return values;
}

LadderRow ladder_row_of(const Campaign &campaign, const Table &table, const std::vector<Row> &rows) {
    LadderRow result;
    result.method = rows[0].method;
    result.amplitude_px = rows[0].amplitude_px;
    result.seeds = rows.size();
    for (const Row &row : rows)
        result.found += found(campaign, row) ? 1 : 0;
    result.period_error = median(values_of(rows, [&](const Row &row) { return period_error(campaign, row); }));
    result.log10_fap = median(values_of(rows, [](const Row &row) { return row.log10_fap; }));
    result.slope = median(values_of(rows, [](const Row &row) { return row.slope; }));
    result.efficiency = median(values_of(rows, [&](const Row &row) { return efficiency(table, row); }));
    result.expected_log10_fap = campaign.theory().log10_fap(result.amplitude_px, table.frames->info.crb_projected_px);
    return result;
}

// Scatter in px for each seed, pooled over its series.
std::vector<double> pooled_sigmas(const std::vector<Row> &rows) {
    std::map<uint64_t, std::vector<double>> squares;
    for (const Row &row : rows)
        squares[row.seed].push_back(row.sigma * row.sigma / (row.slope * row.slope));
    std::vector<double> sigmas;
    sigmas.reserve(squares.size());
    for (const auto &[seed, of_seed] : squares)
        sigmas.push_back(std::sqrt(mean(of_seed)));
    return sigmas;
}

Control control_of(const Campaign &campaign, const Table &table, const std::vector<Row> &rows) {
    Control control;
    control.method = rows[0].method;
    control.series = rows.size();
    control.frames = rows.size() * static_cast<size_t>(campaign.scene().info.frames);
    for (const Row &row : rows)
        control.alarms += row.log10_fap < kFound ? 1 : 0;
    control.uniformity = uniformity(values_of(rows, [](const Row &row) { return std::pow(10, row.log10_fap); }));
    control.sigma_px = median(pooled_sigmas(rows));
    control.efficiency = table.frames->info.crb_projected_px / control.sigma_px;
    control.bias_px = mean(values_of(rows, [](const Row &row) { return row.mean; }));
    control.slope = mean(values_of(rows, [](const Row &row) { return row.slope; }));
    return control;
}

} // namespace

double period_error(const Campaign &campaign, const Row &row) {
    return std::fabs(row.period_days / campaign.scene().info.period_days - 1);
}

bool found(const Campaign &campaign, const Row &row) {
    return row.log10_fap < kFound && period_error(campaign, row) < kClose;
}

double efficiency(const Table &table, const Row &row) {
    return table.frames->info.crb_projected_px * std::fabs(row.slope) / row.sigma;
}

std::vector<TableSummary> summarise(const Campaign &campaign, const Journal &journal) {
    std::vector<TableSummary> summaries;
    for (const Table &table : campaign.tables()) {
        TableSummary summary;
        summary.table = &table;
        summary.crb_px = table.frames->info.crb_projected_px;
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

} // namespace cli
