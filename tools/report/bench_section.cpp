// What `make bench` left: speed against error.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "result_file.hpp"
#include "sections.hpp"
#include "words.hpp"

namespace cli {

namespace {

constexpr const char *kSchema = "toliman-bench/1";
using Items = std::vector<const cJSON *>;
using Numbers = std::vector<double>;

// Letters, digits and - of a name, for files.
std::string file_name(const std::string &text) {
    std::string name;
    for (const char letter : text)
        name += (letter >= '0' && letter <= '9') || (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z')
                    ? letter
                    : '-';
    return name;
}

std::string text_or(const ResultFile &file, const cJSON *row, const char *key) {
    return cJSON_HasObjectItem(row, key) ? file.text_in(row, key) : "";
}

// Rows with an error, by series, in their order.
Figure pareto(const ResultFile &file, const std::string &bench, const Items &rows) {
    std::vector<std::string> names;
    std::map<std::string, std::pair<Numbers, Numbers>> points;
    for (const cJSON *row : rows) {
        const double error = file.number_in(row, "error", NAN), seconds = file.number_in(row, "seconds", NAN);
        if (!(error > 0 && seconds > 0))
            continue;
        const std::string name = text_or(file, row, "series");
        if (points.find(name) == points.end())
            names.push_back(name);
        points[name].first.push_back(error);
        points[name].second.push_back(seconds);
    }
    Figure figure = {"bench-" + file_name(bench), "", 400, "", {}};
    if (names.empty())
        return figure;
    std::string plots;
    for (size_t i = 0; i < names.size(); i++) {
        const auto &[error, seconds] = points[names[i]];
        figure.script += data_block("series" + std::to_string(i), {&error, &seconds});
        plots += printed("%s$series%zu using 1:2 with points pt %zu ps 1.1 lw 1.5 lc rgb '%s' title ",
                         i > 0 ? ", " : "", i, 5 + 2 * (i % 5), line_colour(i)) +
                 gnuplot_text(names[i]);
    }
    figure.script += stacked(0, 1, figure) +
                     "set logscale xy\nset format xy '10^{%T}'\nset key outside right top\nset rmargin at screen 0.72\n"
                     "set offsets graph 0.05, graph 0.05, graph 0.05, graph 0.05\n"
                     "set xlabel 'error (relative)'\nset ylabel 'seconds'\nplot " +
                     plots + "\n";
    figure.caption = escaped(bench) + ": seconds against error; better is lower and further left.";
    return figure;
}

std::string machine_text(const ResultFile &file) {
    std::string text;
    const JsonTree &tree = file.tree();
    const cJSON *fact = nullptr;
    cJSON_ArrayForEach(fact, cJSON_GetObjectItemCaseSensitive(tree.get(), "machine")) {
        if (fact->string == nullptr || !(cJSON_IsString(fact) || cJSON_IsNumber(fact)))
            continue;
        text += (text.empty() ? "" : ", ") + escaped(fact->string) + " " +
                (cJSON_IsString(fact) ? escaped(fact->valuestring) : printed("%g", fact->valuedouble));
    }
    return text;
}

void add_bench(const ResultFile &file, const std::string &bench, const Items &rows, Page &page) {
    page.add_heading(escaped(bench));
    Figure figure = pareto(file, bench, rows);
    if (!figure.script.empty())
        page.add(std::move(figure));
    std::vector<std::vector<std::string>> cells;
    for (const cJSON *row : rows) {
        const std::string peer = escaped(text_or(file, row, "peer"));
        const double ratio = file.number_in(row, "ratio_peer", NAN);
        cells.push_back({escaped(file.text_in(row, "what")), escaped(text_or(file, row, "series")),
                         scientific(file.number_in(row, "seconds", NAN)),
                         scientific(file.number_in(row, "spread", NAN), 2),
                         scientific(file.number_in(row, "error", NAN), 2),
                         std::isfinite(ratio) ? printed("%.3g ", ratio) + "&times; " + peer : "&ndash;",
                         scientific(file.number_in(row, "ratio_roofline", NAN))});
    }
    page.add_table(
        "Median seconds and their spread; error; how many times faster than the peer in the same run; time over "
        "that of the roofline.",
        {"what", "series", "seconds", "spread", "error", "peer", "of roofline"}, cells);
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
    std::string machine;
    for (const std::string &path : bench_files(folder)) {
        const ResultFile file(path, kSchema);
        progress.show("report: bench", 0.5);
        const std::string facts = machine_text(file);
        if (facts != machine)
            page.add_text("Machine: " + facts + ".");
        machine = facts;
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
}

} // namespace cli
