// What `make bench` left: speed against error.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "report/result_file.hpp"
#include "report/sections.hpp"
#include "report/words.hpp"

namespace cli {

namespace {

constexpr const char *kSchema = "toliman-bench/1";

// What is drawn against what.
struct Axes {
    const char *x, *y, *labels, *caption; // keys of a row; gnuplot's settings
};
constexpr Axes kSpeed = {"error", "seconds",
                         "set logscale xy\nset format xy '10^{%T}'\nset xlabel 'error (relative)'\n"
                         "set ylabel 'seconds'\n",
                         ": seconds against error; better is lower and further left."};
constexpr Axes kBytes = {"bytes", "efficiency",
                         "set format x '%.1s %cB'\nset format y '%.4f'\nset xlabel 'bytes of the weights file'\n"
                         "set ylabel 'efficiency (no unit)'\n",
                         ": efficiency against bytes, of the same frames; better is higher and further left."};

using Points = std::map<std::string, std::pair<Numbers, Numbers>>;
constexpr size_t kFewest = 7; // points that are worth a figure

size_t points_in(const Points &points) {
    size_t count = 0;
    for (const auto &[name, xy] : points)
        count += xy.first.size();
    return count;
}

// Rows that have both, by series, in their order.
Figure pareto(const ResultFile &file, const std::string &bench, const Items &rows, const Axes &axes) {
    std::vector<std::string> names;
    Points points;
    for (const cJSON *row : rows) {
        const double x = file.number_in(row, axes.x, NAN), y = file.number_in(row, axes.y, NAN);
        if (!(x > 0 && y > 0))
            continue;
        const std::string name = file.text_in(row, "series", "");
        if (points.find(name) == points.end())
            names.push_back(name);
        points[name].first.push_back(x);
        points[name].second.push_back(y);
    }
    Figure figure = {"bench-" + bench, "", 400, "", {}};
    if (points_in(points) < kFewest)
        return figure;
    std::string plots;
    for (size_t i = 0; i < names.size(); i++) {
        const auto &[x, y] = points[names[i]];
        figure.script += data_block("series" + std::to_string(i), {&x, &y});
        plots += printed("%s$series%zu using 1:2 with points ps 1.1 lw 1.5 ", i > 0 ? ", " : "", i) + mark(i) +
                 " title " + gnuplot_text(names[i]);
    }
    figure.script += stacked(0, 1, figure) + axes.labels +
                     "set key outside right top\nset rmargin at screen 0.72\n"
                     "set offsets graph 0.05, graph 0.05, graph 0.05, graph 0.05\nplot " +
                     plots + "\n";
    figure.caption = escaped(bench) + axes.caption;
    return figure;
}

// What a reader compares machines by.
std::string machine_text(const ResultFile &file) {
    std::string text;
    const cJSON *machine = cJSON_GetObjectItemCaseSensitive(file.tree().get(), "machine");
    for (const char *key : {"date", "cpu", "isa", "blas_core", "fftw"}) {
        const cJSON *fact = cJSON_GetObjectItemCaseSensitive(machine, key);
        if (cJSON_IsString(fact))
            text += (text.empty() ? "Machine: " : ", ") + escaped(fact->valuestring);
    }
    return text + ".";
}

// In the unit that suits it.
std::string duration(double seconds) {
    return seconds >= 1      ? printed("%.3g&nbsp;s", seconds)
           : seconds >= 1e-3 ? printed("%.3g&nbsp;ms", seconds * 1e3)
                             : printed("%.3g&nbsp;&micro;s", seconds * 1e6);
}

std::string ratio(double value, const char *format) {
    return std::isfinite(value) ? printed(format, value) : "";
}

std::string error_text(const ResultFile &file, const cJSON *row) {
    const double error = file.number_in(row, "error", NAN);
    const std::string of = file.text_in(row, "error_of", ""), at = file.text_in(row, "error_at", "");
    return std::isfinite(error)
               ? scientific(error, 1) + escaped((of.empty() ? "" : " " + of) + (at.empty() ? "" : " at " + at))
               : "";
}

// Half of what the middle half of the runs spans, of the median.
std::string spread_text(double part) {
    return part < 0.005 ? "&lt;&nbsp;1&nbsp;%" : ratio(100 * part, "%.0f&nbsp;%%");
}

std::vector<std::string> cells_of(const ResultFile &file, const cJSON *row) {
    const double seconds = file.number_in(row, "seconds");
    return {escaped(file.text_in(row, "what")),
            duration(seconds),
            spread_text(file.number_in(row, "spread", NAN) / seconds),
            error_text(file, row),
            escaped(file.text_in(row, "peer", "")),
            ratio(file.number_in(row, "ratio_peer", NAN), "%.3g"),
            ratio(file.number_in(row, "ratio_roofline", NAN), "%.2f")};
}

using Cells = std::vector<std::vector<std::string>>;

void add_cells(const std::string &caption, const Cells &cells, Page &page) {
    if (!cells.empty())
        page.add_table(caption, {"", "time", "&plusmn;", "error", "peer", "takes times", "of the least"}, cells);
}

Items headlines(const ResultFile &file) {
    Items rows;
    for (const cJSON *row : file.list("rows"))
        if (cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(row, "headline")))
            rows.push_back(row);
    return rows;
}

// A table for each machine, mostly one.
void add_headlines(const std::vector<ResultFile> &files, Page &page) {
    std::string machine;
    Cells cells;
    for (const ResultFile &file : files) {
        const std::string facts = machine_text(file);
        if (facts != machine) {
            add_cells(machine, cells, page);
            cells.clear();
        }
        machine = facts;
        for (const cJSON *row : headlines(file))
            cells.push_back(cells_of(file, row));
    }
    add_cells(machine, cells, page);
}

void add_bench(const ResultFile &file, const std::string &bench, const Items &rows, Page &page) {
    page.add_heading(escaped(bench));
    Figure figure = pareto(file, bench, rows, cJSON_HasObjectItem(rows[0], "bytes") ? kBytes : kSpeed);
    if (!figure.script.empty())
        page.add(std::move(figure));
    Cells cells;
    for (const cJSON *row : rows)
        cells.push_back(cells_of(file, row));
    add_cells("", cells, page);
}

void add_benches(const ResultFile &file, Page &page) {
    std::vector<std::string> names;
    std::map<std::string, Items> benches;
    for (const cJSON *row : file.list("rows")) {
        const std::string name = file.text_in(row, "bench");
        if (benches.find(name) == benches.end())
            names.push_back(name);
        benches[name].push_back(row);
    }
    for (const std::string &name : names)
        add_bench(file, name, benches[name], page);
}

} // namespace

std::vector<std::string> bench_files(const std::string &folder) {
    std::vector<std::string> files;
    std::error_code error;
    for (const auto &entry : std::filesystem::directory_iterator(folder, error))
        if (entry.path().extension() == ".json" && entry.is_regular_file(error) &&
            schema_of(entry.path().string()) == kSchema)
            files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    return files;
}

void add_bench_section(const std::string &folder, Page &page, Progress &progress) {
    page.add_title("make bench: speed against error");
    std::vector<ResultFile> files;
    for (const std::string &path : bench_files(folder))
        files.emplace_back(path, kSchema);
    page.add_text(
        "Medians of processor time on one core and half of what the middle half of the runs spans; the largest "
        "error, of all or of as many as it says; a peer that was measured in the same run and how many times as long "
        "it takes; the time over the "
        "least that the machine allows.");
    add_headlines(files, page);
    for (size_t i = 0; i < files.size(); i++) {
        progress.show("report: bench", static_cast<double>(i) / static_cast<double>(files.size()));
        add_benches(files[i], page);
    }
}

} // namespace cli
