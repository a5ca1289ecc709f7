#include "series/detection_map.hpp"

#include <CLI/App.hpp>
#include <mutex>
#include <sstream>

#include "common/content.hpp"
#include "common/parallel.hpp"
#include "options/command.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

constexpr int64_t kMostCells = 1000; // on one axis
constexpr double kAround = 10;       // ratio of the largest size to one that is detected, and of this to the smallest
constexpr char kColumns[] = "cell,period_min,period_max,%s_min,%s_max,injections,detected\n";

// Next number below or above with one digit.
double rounded(double value, bool up) {
    const double unit = std::pow(10, std::floor(std::log10(value)));
    return (up ? std::ceil(value / unit) : std::floor(value / unit)) * unit;
}

std::pair<double, double> masses_of(const std::string &text) {
    const size_t comma = text.find(',');
    double least = 0, most = 0;
    const bool is_pair = comma != std::string::npos && number_of(text.substr(0, comma), least) &&
                         number_of(text.substr(comma + 1), most);
    if (!is_pair || !(least > 0 && least < most && std::isfinite(most)))
        throw Failure(kExitUsage, "--map-masses " + text + ": must be MIN,MAX with 0 < MIN < MAX");
    return {least, most};
}

// A decade on either side of the size that is detectable in the middle of the periods.
std::pair<double, double> default_sizes(const PlanetSearch &search, bool masses) {
    const double middle = std::sqrt(search.info.period_min * search.info.period_max);
    const toliman_planet_limit limit = limits_at(search, {middle})[0];
    const double size = masses ? limit.detectable_mass_a : limit.detectable;
    if (!(size > 0 && std::isfinite(size)))
        throw Failure(kExitUsage,
                      formatted("--map: no planet of %g d is detected with a probability of %g%s", limit.period,
                                kLimitProbability, masses ? ": give --map-masses MIN,MAX" : ""));
    return {rounded(size / kAround, false), rounded(size * kAround, true)};
}

// A bijection that puts seeds far apart, so that the cells of two maps share no seed (splitmix64).
uint64_t scattered(uint64_t seed) {
    seed = (seed ^ (seed >> 30)) * 0xbf58476d1ce4e5b9;
    seed = (seed ^ (seed >> 27)) * 0x94d049bb133111eb;
    return seed ^ (seed >> 31);
}

// All that the cells depend on.
Json settings_of(const DetectionMap &map, const PlanetSearch &search) {
    const toliman_planet_options &how = search.options;
    const toliman_planet_info &info = search.info;
    return Json("version", toliman_version(), "series", digest_text(info.series_digest), "velocity",
                search.unit.is_velocity, "jitter", (how.flags & TOLIMAN_PLANET_NO_JITTER) == 0, "unit",
                Exact{search.unit.factor}, "parallax_arcsec", Exact{how.parallax_arcsec}, "star_mass",
                std::vector{Exact{how.star_mass[0]}, Exact{how.star_mass[1]}}, "max", how.max_planets, "samples",
                how.samples, "threshold", Exact{how.threshold}, "period_min", Exact{info.period_min}, "period_max",
                Exact{info.period_max}, "fap", Exact{how.detection_fap}, "star", map.star, "cells",
                shape_text(map.periods(), map.sizes()), map.star < 0 ? "amplitudes" : "masses",
                std::vector{Exact{map.size_edges.front()}, Exact{map.size_edges.back()}}, "injections", map.injections,
                "seed", std::to_string(map.seed));
}

} // namespace

void MapOptions::add_to(CLI::App &command) {
    CLI::Option *map = command.add_flag("--map", is_wanted);
    add_option(&command, "--map-cells", cells, "PxM");
    add_option(&command, "--map-masses", masses, "MIN,MAX");
    command.add_option("--map-injections", injections)->check(CLI::Range(1u, 1000000u));
    for (const char *name : {"--map-cells", "--map-masses", "--map-injections"})
        command.get_option(name)->needs(map);
}

toliman_planet_cell DetectionMap::cell(size_t k) const {
    const size_t period = k % periods(), size = k / periods();
    auto cell = toliman::sized<toliman_planet_cell>();
    cell.star = star;
    cell.period_min = period_edges[period];
    cell.period_max = period_edges[period + 1];
    cell.size_min = size_edges[size];
    cell.size_max = size_edges[size + 1];
    cell.count = injections;
    cell.seed = scattered(seed) + k;
    return cell;
}

void DetectionMap::print() const {
    std::string text = formatted(
        "map         %% detected of %u planets per cell; columns: periods from %.4g to %.4g d; "
        "rows: %s\n",
        injections, period_edges.front(), period_edges.back(), star < 0 ? "amplitudes" : "masses on A in Earths");
    for (size_t size = sizes(); size-- > 0;) {
        text += formatted("  %9.3g ", std::sqrt(size_edges[size] * size_edges[size + 1]));
        for (size_t period = 0; period < periods(); period++)
            text += formatted(" %3.0f", 100.0 * detected[size * periods() + period] / injections);
        text += "\n";
    }
    print_stdout(text);
}

Json DetectionMap::json() const {
    std::vector<std::vector<uint32_t>> rows;
    for (size_t size = 0; size < sizes(); size++)
        rows.emplace_back(detected.begin() + static_cast<std::ptrdiff_t>(size * periods()),
                          detected.begin() + static_cast<std::ptrdiff_t>((size + 1) * periods()));
    return Json("star", if_known(star >= 0, "A"), "size", size_name(), "period_edges", period_edges, "size_edges",
                size_edges, "injections", injections, "detected", rows);
}

DetectionMap empty_map(const MapOptions &options, const PlanetSearch &search, uint64_t seed) {
    int64_t periods = 0, sizes = 0;
    if (!two_numbers(options.cells, 'x', periods, sizes) || periods < 1 || sizes < 1 || periods > kMostCells ||
        sizes > kMostCells)
        throw Failure(kExitUsage,
                      "--map-cells " + options.cells +
                          formatted(": must be PxM with numbers in [1, %lld]", static_cast<long long>(kMostCells)));
    const bool masses = search.knows_mass(0);
    if (!masses && !options.masses.empty())
        throw Failure(kExitUsage, std::string("--map-masses: needs --unit") +
                                      (search.unit.is_velocity ? "" : ", --parallax") + " and --star-masses");
    const auto [least, most] = options.masses.empty() ? default_sizes(search, masses) : masses_of(options.masses);
    DetectionMap map;
    map.star = masses ? 0 : -1;
    map.period_edges = edges_between(search.info.period_min, search.info.period_max, static_cast<size_t>(periods));
    map.size_edges = edges_between(least, most, static_cast<size_t>(sizes));
    map.injections = options.injections;
    map.seed = seed;
    map.detected.assign(map.periods() * map.sizes(), 0);
    return map;
}

MapFile::MapFile(const std::string &path, const DetectionMap &map, const PlanetSearch &search)
    : map_(map), file_(path) {
    const Json settings = settings_of(map, search);
    if (file_.text().empty())
        file_.begin(kPlanetMapMark + ("# " + settings.line()) + formatted(kColumns, map.size_name(), map.size_name()));
    else
        read(settings);
}

// Throws Failure unless the object `found` of the file has the members of `settings`.
void MapFile::check_settings(const cJSON *found, const Json &settings) const {
    const JsonTree wanted(cJSON_Parse(settings.line().c_str()));
    for (const cJSON *item = wanted->child; item != nullptr; item = item->next) {
        const cJSON *there = cJSON_GetObjectItemCaseSensitive(found, item->string);
        if (cJSON_Compare(item, there, 1) == 0)
            throw Failure(kExitUsage,
                          formatted("%s: %s = %s: must be %s, as in this search: give another --out or the same "
                                    "arguments",
                                    file_.path().c_str(), item->string,
                                    there != nullptr ? line_of(there).c_str() : "nothing", line_of(item).c_str()));
    }
}

void MapFile::read(const Json &settings) {
    std::istringstream lines(file_.text());
    std::string mark, line, columns;
    std::getline(lines, mark);
    std::getline(lines, line);
    std::getline(lines, columns);
    const JsonTree found(mark + "\n" == kPlanetMapMark && line.size() > 2 ? cJSON_Parse(line.c_str() + 2) : nullptr);
    if (!cJSON_IsObject(found.get()))
        malformed(file_.path(), "is not a detection map of toliman planet: give another --out");
    check_settings(found.get(), settings);
    while (std::getline(lines, line)) {
        double detected = -1;
        number_of(line.substr(line.rfind(',') + 1), detected);
        const auto count = static_cast<uint32_t>(std::clamp(detected, 0.0, static_cast<double>(map_.injections)));
        if (detected_.size() == map_.detected.size() || line + "\n" != row(count))
            malformed(file_.path() + ":" + std::to_string(detected_.size() + 4),
                      "is not the next cell of this map: remove it and all lines after it");
        detected_.push_back(count);
    }
}

std::string MapFile::row(uint32_t detected) const {
    const toliman_planet_cell cell = map_.cell(detected_.size());
    return formatted("%zu,%.17g,%.17g,%.17g,%.17g,%u,%u\n", detected_.size(), cell.period_min, cell.period_max,
                     cell.size_min, cell.size_max, cell.count, detected);
}

void MapFile::add(uint32_t detected) {
    file_.add(row(detected));
    detected_.push_back(detected);
}

void fill(DetectionMap &map, const PlanetSearch &search, MapFile *file, Progress &progress) {
    size_t next = 0; // the first cell that is not known; those before it are in the file
    if (file != nullptr)
        for (const uint32_t detected : file->detected())
            map.detected[next++] = detected;
    const size_t first = next, all = map.detected.size();
    std::vector<bool> is_known(all);
    size_t known = first;
    std::mutex mutex; // of all above
    const auto take = [&](size_t k, uint32_t detected) {
        const std::lock_guard<std::mutex> lock(mutex);
        map.detected[k] = detected;
        is_known[k] = true;
        known++;
        for (; next < all && is_known[next]; next++)
            if (file != nullptr)
                file->add(map.detected[next]);
        progress.show("map", static_cast<double>(known) / static_cast<double>(all));
    };
    run_parallel(
        all - first,
        [&](size_t i) {
            stop_if_asked();
            const toliman_planet_cell cell = map.cell(first + i);
            uint32_t detected = 0;
            toliman::check(toliman_planet_inject(search.handle.get(), &cell, &detected));
            take(first + i, detected);
        },
        search.options.threads);
}

} // namespace cli
