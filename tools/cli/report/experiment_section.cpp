// What `toliman experiment` left: ladders, series without signal, tables.
#include <algorithm>
#include <cmath>
#include <map>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "experiment/methods.hpp"
#include "report/glossary.hpp"
#include "report/result_file.hpp"
#include "report/sections.hpp"
#include "report/words.hpp"

namespace cli {

namespace {

constexpr double kLeastShown = 0.05; // -log10 FAP
constexpr const char *kKeyBeside = "set rmargin at screen 0.8\nset key outside right top\n";

const std::vector<Word> kWords = {
    {"seed", "of random weights and of noise: each is a trial of its own"},
    {"found", "log<sub>10</sub> FAP below &minus;3 and the period within 5 % of the true one"},
    {"at the bound", "what theory expects of a method whose scatter is the Cram&eacute;r-Rao bound"},
    {"slope", "what a method's value changes by for each px of displacement: 1 where values are px; methods that learn "
              "from the series have units of their own and either sign"},
    {"efficiency",
     "the Cram&eacute;r-Rao bound over a method's scatter about that slope, in px: 1 at best, but for chance"},
    {"bias", "mean of a method's values where there is no signal"},
    {"uniform, KS p",
     "Kolmogorov-Smirnov: how often FAPs that are uniform, as those of noise should be, look as uneven "
     "as these; suspicious below 0.01"},
    {"uniform, &plusmn; 1 sigma", "how many series each interval should have, and in grey how far chance takes that"},
    kBoundWord,
    kFapWord,
};

// Of JSON objects or rows, in the order in which they come.
struct Methods {
    std::vector<std::string> names;
    std::map<std::string, Items> of;
    Methods(const ResultFile &result, const Items &items) {
        for (const cJSON *item : items) {
            const std::string name = result.text_in(item, "method");
            if (of.find(name) == of.end())
                names.push_back(name);
            of[name].push_back(item);
        }
    }
};

// Most seeds found the signal: else slope and efficiency are those of noise.
bool is_seen(const ResultFile &result, const cJSON *rung) {
    return 2 * result.number_in(rung, "found") > result.number_in(rung, "seeds");
}

Figure ladder_figure(const ResultFile &result, const cJSON *table, const Items &ladder) {
    const Methods methods(result, ladder);
    const double threshold = result.number_in(table, "threshold_px");
    Numbers amplitudes;
    for (const cJSON *rung : ladder)
        amplitudes.push_back(result.positive_in(rung, "amplitude_px"));
    const auto [least, greatest] = std::minmax_element(amplitudes.begin(), amplitudes.end());
    Figure figure = {"ladder-" + result.text_in(table, "table"), "", 620, "", {}};
    std::map<double, double> bound;
    std::string blocks, faps, efficiencies;
    for (size_t i = 0; i < methods.names.size(); i++) {
        std::map<double, std::array<double, 2>> points;
        for (const cJSON *rung : methods.of.at(methods.names[i])) {
            const double amplitude = result.number_in(rung, "amplitude_px");
            points[amplitude] = {std::max(-result.number_in(rung, "log10_fap"), kLeastShown),
                                 is_seen(result, rung) ? result.number_in(rung, "efficiency") : NAN};
            bound[amplitude] = std::max(-result.number_in(rung, "expected_log10_fap"), kLeastShown);
        }
        Numbers x, fap, efficiency;
        for (const auto &[amplitude, point] : points) {
            x.push_back(amplitude);
            fap.push_back(point[0]);
            efficiency.push_back(point[1]);
        }
        blocks += data_block("method" + std::to_string(i), {&x, &fap, &efficiency});
        const std::string style = " with linespoints lw 1.5 ps 0.8 " + mark(i);
        faps += printed(", $method%zu using 1:2", i) + style + " title " + gnuplot_text(methods.names[i]);
        efficiencies += printed("%s$method%zu using 1:3", i > 0 ? ", " : "", i) + style + " notitle";
    }
    Numbers x, y;
    for (const auto &[amplitude, fap] : bound) {
        x.push_back(amplitude);
        y.push_back(fap);
    }
    figure.script = blocks + data_block("bound", {&x, &y}) +
                    printed("set logscale x\nset xrange [%.10g:%.10g]\nset multiplot\n",
                            std::min(*least, threshold > 0 ? threshold : *least) / 1.5, *greatest * 1.5);
    if (threshold > 0)
        figure.script +=
            printed("set arrow 1 from first %.10g, graph 0 to first %.10g, graph 1 nohead dt 3 lw 1.3 lc rgb "
                    "'#444444'\n",
                    threshold, threshold);
    figure.script +=
        stacked(0, 2, figure) + kKeyBeside +
        "unset xlabel\nset format x ''\nset logscale y\nset format y '%g'\n"

        "set ylabel '−log_{10} FAP (no unit)'\n" +
        printed("plot [][%g:*] $bound using 1:2 with lines dt 2 lw 1.8 lc rgb '#222222' title 'at the bound', "
                "3 with lines lw 1 lc rgb '#999999' title 'found: FAP 0.001'",
                kLeastShown) +
        faps + "\n" + stacked(1, 2, figure) + kKeyBeside +
        "set xlabel 'amplitude of the signal, px'\nset format x '10^{%T}'\nunset logscale y\n"
        "set ylabel 'efficiency (no unit)'\nplot [][0:1.15] " +
        efficiencies + ", 1 with lines dt 2 lw 1.8 lc rgb '#222222' notitle\nunset multiplot\n";
    figure.caption =
        "Above: the significance of the highest peak, median over the seeds; dashed what theory expects at the "
        "Cram&eacute;r-Rao bound. Below: the efficiency, where most seeds found the signal. Dotted: "
        "the amplitude from which a method at the bound is expected to find it, " +
        scientific(threshold) +
        " px. A network may lose efficiency at large amplitudes: it is linear only near the scene's reference, and "
        "beyond, its values bend by more than the noise.";
    return figure;
}

// Of px a px, so about 1, or of a method's own units.
std::string slope_text(double slope) {
    return std::fabs(slope) >= 0.1 && std::fabs(slope) < 10 ? fixed(slope, 3) : exponential(slope);
}

// Two digits.
std::string percent_text(double part) {
    return fixed(100 * part, decimals_of(100 * part, 0));
}

void add_ladder_table(const ResultFile &result, const Items &ladder, Page &page) {
    std::vector<std::vector<std::string>> rows;
    double last = NAN;
    for (const cJSON *rung : ladder) {
        const double amplitude = result.number_in(rung, "amplitude_px");
        if (amplitude != last)
            rows.push_back({"at the bound", exponential(amplitude), "", "",
                            fixed(result.number_in(rung, "expected_log10_fap"), 1), "1", "1"});
        last = amplitude;
        const bool seen = is_seen(result, rung);
        rows.push_back({escaped(result.text_in(rung, "method")), exponential(amplitude),
                        printed("%.0f of %.0f", result.number_in(rung, "found"), result.number_in(rung, "seeds")),
                        percent_text(result.number_in(rung, "period_error")),
                        fixed(result.number_in(rung, "log10_fap"), 1),
                        seen ? slope_text(result.number_in(rung, "slope")) : "",
                        seen ? fixed(result.number_in(rung, "efficiency"), 3) : ""});
    }
    page.add_table(
        "Medians over the seeds; slope and efficiency where most of them found the signal.",
        {"method", "amplitude, px", "found", "period error, %", "log<sub>10</sub> FAP", "slope", "efficiency"}, rows);
}

void add_control_table(const ResultFile &result, const Items &controls, Page &page) {
    std::vector<std::vector<std::string>> rows;
    for (const cJSON *control : controls)
        rows.push_back({escaped(result.text_in(control, "method")), fixed(result.number_in(control, "series"), 0),
                        fixed(result.number_in(control, "alarms"), 0), fixed(result.number_in(control, "ks_p"), 2),
                        exponential(result.number_in(control, "sigma_px")),
                        fixed(result.number_in(control, "efficiency"), 3)});
    page.add_table(
        "Series without signal: what each method makes of noise alone.",
        {"method", "series", "alarms at FAP 10<sup>&minus;3</sup>", "uniform, KS p", "sigma, px", "efficiency"}, rows);
}

// FAPs of the series without signal, by table and method.
using BlindFaps = std::map<std::string, std::map<std::string, Numbers>>;

BlindFaps read_blind(const std::string &path) {
    BlindFaps faps;
    for_rows(path, {"table", "method", "amplitude_px", "log10_fap"}, [&](const Cells &cells) {
        if (number_of(path, cells[2]) == 0)
            faps[cells[0]][cells[1]].push_back(std::pow(10, number_of(path, cells[3])));
    });
    return faps;
}

Figure blind_figure(const std::string &table, const std::map<std::string, Numbers> &methods,
                    const std::vector<std::string> &order) {
    size_t series = 0;
    for (const auto &[method, faps] : methods)
        series = std::max(series, faps.size());
    const size_t bins = series >= 200 ? 20 : series >= 50 ? 10 : 5;
    Figure figure = {"blind-" + table, "", 340, "", {}};
    std::string blocks, plots;
    size_t shown = 0;
    double highest = 0;
    const double width = 1 / static_cast<double>(bins), bar = width * 0.85 / static_cast<double>(methods.size());
    for (size_t i = 0; i < order.size(); i++) {
        const auto found = methods.find(order[i]);
        if (found == methods.end())
            continue;
        Numbers x(bins), y(bins);
        for (size_t k = 0; k < bins; k++)
            x[k] = (static_cast<double>(k) + 0.075) * width + bar * (static_cast<double>(shown) + 0.5);
        for (const double fap : found->second)
            if (fap >= 0) // not NaN
                y[static_cast<size_t>(std::min(fap / width, static_cast<double>(bins - 1)))] += 1;
        highest = std::max(highest, *std::max_element(y.begin(), y.end()));
        blocks += data_block("method" + std::to_string(i), {&x, &y});
        plots += printed(", $method%zu using 1:2:(%.6g) with boxes fs solid 0.85 noborder lc rgb '%s' title ", i, bar,
                         line_colour(i)) +
                 gnuplot_text(order[i]);
        shown++;
    }
    const double each = static_cast<double>(series) * width, sigma = std::sqrt(each * (1 - width));
    figure.script =
        blocks + stacked(0, 1, figure) +
        "set xlabel 'FAP of the highest peak (no unit)'\nset ylabel 'number of series'\nset key horizontal top left\n" +
        printed("set object 1 rectangle from 0,%.6g to 1,%.6g behind fs solid 0.25 noborder fc rgb '#999999'\n",
                std::max(0.0, each - sigma), each + sigma) +
        printed("plot [0:1][0:%.6g] %.6g with lines lw 1.5 dt 2 lc rgb '#222222' title 'uniform, ± 1 sigma'",
                std::max({2 * each, each + 5 * sigma, 1.2 * highest}) + 1, each) +
        plots + "\n";
    figure.caption =
        printed("How many of %zu series without signal have a FAP in each interval, for each method: as many in each, "
                "the dashed line, if the FAP is what it says.",
                series);
    return figure;
}

void add_robust_table(const ResultFile &result, const Items &tables, Page &page) {
    std::vector<std::vector<std::string>> rows;
    for (const cJSON *table : tables)
        for (const cJSON *rung : result.list_in(table, "ladder")) {
            const std::string method = result.text_in(rung, "method");
            std::vector<std::string> row = {escaped(result.text_in(table, "what")), escaped(method)};
            for (const cJSON *control : result.list_in(table, "controls"))
                if (result.text_in(control, "method") == method)
                    row.insert(row.end(), {exponential(result.number_in(control, "bias_px")),
                                           exponential(result.number_in(control, "sigma_px")),
                                           fixed(result.number_in(control, "efficiency"), 3)});
            row.resize(5);
            row.push_back(printed("%.0f of %.0f", result.number_in(rung, "found"), result.number_in(rung, "seeds")));
            row.push_back(fixed(result.number_in(rung, "log10_fap"), 1));
            rows.push_back(row);
        }
    page.add_heading("Frames of other scenes");
    page.add_table("Methods of this scene on frames that differ from it.",
                   {"frames", "method", "bias, px", "sigma, px", "efficiency", "found", "log<sub>10</sub> FAP"}, rows);
}

void add_ladder(const ResultFile &result, const cJSON *table, const BlindFaps &blind, Page &page) {
    const std::string name = result.text_in(table, "table");
    const Items ladder = result.list_in(table, "ladder"), controls = result.list_in(table, "controls");
    page.add_heading("Table " + escaped(name) + ": " + escaped(result.text_in(table, "what")));
    page.add_text("Cram&eacute;r-Rao bound of a frame " + scientific(result.number_in(table, "crb_projected_px"), 4) +
                  " px, all nuisances free " + scientific(result.number_in(table, "crb_marginal_px")) +
                  " px. Flux ratio " + printed("%.3g", result.number_in(table, "flux_ratio")) +
                  ". The signal is the first principal component of whitened frames above " +
                  scientific(result.number_in(table, "pca_threshold_px")) + " px.");
    if (!ladder.empty()) {
        page.add(ladder_figure(result, table, ladder));
        add_ladder_table(result, ladder, page);
    }
    const auto found = blind.find(name);
    if (found != blind.end())
        page.add(blind_figure(name, found->second, Methods(result, ladder).names));
    if (!controls.empty())
        add_control_table(result, controls, page);
}

// One line of each method that the page names, as `experiment --help` has it.
void explain_methods(const ResultFile &result, Page &page) {
    for (const cJSON *table : result.list("tables"))
        for (const std::string &name : Methods(result, result.list_in(table, "ladder")).names)
            for (const MethodKind &kind : method_kinds())
                if (kind.name == name)
                    page.explain({{escaped(name), escaped(kind.what)}});
}

// Ladders have a name that begins no file's path.
bool is_ladder(const std::string &name) {
    return name == "real" || name == "equal";
}

} // namespace

void add_experiment_section(const std::string &folder, Page &page, Progress &progress) {
    const ResultFile result(folder + "/experiment.json", "toliman-experiment/1");
    const BlindFaps blind = read_blind(folder + "/experiment.csv");
    progress.show("report: experiment", 0.1);
    page.add_title("toliman experiment: " + escaped(result.text("scene")));
    page.add_text(printed("%.0f frames a series, period %g days; seeds 1 to %.0f; %.0f series without signal for each "
                          "table. libtoliman ",
                          result.number("frames"), result.number("true_period_days"), result.number("seeds"),
                          result.number("blind")) +
                  escaped(result.text("version")) + ".");
    Items others;
    for (const cJSON *table : result.list("tables"))
        if (is_ladder(result.text_in(table, "table")))
            add_ladder(result, table, blind, page);
        else
            others.push_back(table);
    if (!others.empty())
        add_robust_table(result, others, page);
    explain_methods(result, page);
    page.explain(kWords);
}

} // namespace cli
