#include "state_folder.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "failure.hpp"
#include "input.hpp"

namespace cli {

namespace {

// A file of a state folder that is damaged is no input file.
[[noreturn]] void fail_state(toliman_status status) {
    if (status == TOLIMAN_E_FORMAT)
        throw Failure(kExitState, toliman_last_error());
    throw toliman::error(status);
}

int64_t whole_of(const std::string &text, size_t &at, const std::string &where) {
    int64_t value = 0;
    at = std::min(text.find_first_not_of(" \t", at), text.size());
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), value);
    if (error != std::errc())
        malformed(where, "must be camera_ns,tai_ns, two whole numbers of 64 bits");
    at = std::min(text.find_first_not_of(" \t\r", static_cast<size_t>(end - text.data())), text.size());
    return value;
}

} // namespace

std::optional<toliman_track_options> made_with(const std::string &folder) {
    toliman_track_options options = {};
    options.struct_size = sizeof options;
    const toliman_status status = toliman_track_load_options(folder.c_str(), &options);
    if (status == TOLIMAN_E_NOT_FOUND)
        return std::nullopt;
    if (status != TOLIMAN_OK)
        fail_state(status);
    return options;
}

toliman_track_options known_state(const std::string &folder) {
    const std::optional<toliman_track_options> made = made_with(folder);
    if (!made)
        malformed(folder, "is no state folder of `toliman track`");
    toliman_track_options how = *made;
    how.folder = folder.c_str();
    return how;
}

toliman::tracker open_tracker(const toliman_track_options &options) {
    toliman_track *tracker = nullptr;
    const toliman_status status = toliman_track_create(&options, &tracker);
    if (status != TOLIMAN_OK)
        fail_state(status);
    return toliman::tracker(tracker);
}

toliman_track_info info_of(const toliman::tracker &tracker) {
    toliman_track_info info = {};
    info.struct_size = sizeof info;
    toliman::check(toliman_track_get_info(tracker.get(), &info));
    return info;
}

bool has_clock(const toliman::tracker &tracker) {
    size_t points = 0;
    toliman::check(toliman_track_get_clock(tracker.get(), nullptr, 0, &points));
    return points > 0;
}

FrequencyGrid grid_of(const std::string &text) {
    FrequencyGrid grid = {};
    long long nf = 0;
    char rest = '\0';
    if (std::sscanf(text.c_str(), "%lf:%lf:%lld%c", &grid.f0, &grid.df, &nf, &rest) != 3)
        throw Failure(kExitUsage, "--grid " + text + ": must be F0:DF:NF in cycles a day, e.g. 0.001:0.0001:5000");
    grid.nf = nf;
    if (!(grid.f0 >= 0) || !(grid.df > 0) || nf < 1 || nf > (1 << 26) || !std::isfinite(grid.f0 + grid.df))
        throw Failure(kExitUsage, "--grid " + text + ": must be F0 >= 0, DF > 0 and 1 <= NF <= 2^26");
    return grid;
}

void set_grid(const FrequencyGrid &grid, toliman_track_options &options) {
    options.f0 = grid.f0;
    options.df = grid.df;
    options.nf = grid.nf;
    options.period_flags = TOLIMAN_PERIOD_WIDE; // as `run` and `period`
}

std::vector<int64_t> read_clock(const std::string &path) {
    if (path.empty())
        return {};
    if (path == "camera")
        return {0, 0};
    InputFile file(path);
    std::string text(file.size(), '\0');
    if (!file.read(text.data(), text.size()))
        malformed(path, "cannot be read");
    std::vector<int64_t> clock;
    int number = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        const std::string line = text.substr(at, end - at), where = path + ":" + std::to_string(++number);
        at = end + 1;
        const size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string::npos || line[first] == '#' ||
            (number == 1 && std::isalpha(static_cast<unsigned char>(line[first])) != 0))
            continue;
        size_t column = 0;
        clock.push_back(whole_of(line, column, where));
        if (column >= line.size() || line[column++] != ',')
            malformed(where, "must be camera_ns,tai_ns, two whole numbers of 64 bits");
        clock.push_back(whole_of(line, column, where));
        if (column != line.size())
            malformed(where, "must be camera_ns,tai_ns, two whole numbers of 64 bits");
    }
    if (clock.empty())
        malformed(path, "holds no pair camera_ns,tai_ns");
    return clock;
}

void set_clock(const std::vector<int64_t> &clock, toliman_track_options &options) {
    options.clock = clock.data();
    options.clock_points = clock.size() / 2;
}

namespace {

// NaN in all numbers.
toliman_period_peak unknown_peak() noexcept {
    toliman_period_peak peak = {};
    peak.struct_size = sizeof peak;
    for (double *number :
         {&peak.frequency, &peak.period, &peak.power, &peak.fwhm_error, &peak.frequency_error, &peak.amplitude,
          &peak.amplitude_error, &peak.phase, &peak.offset, &peak.log10_fap, &peak.period_error})
        *number = NAN;
    return peak;
}

// Few frames, or hardly different ones, tell nothing.
bool is_known(toliman_status status) {
    if (status == TOLIMAN_E_STATE || status == TOLIMAN_E_RANGE)
        return false;
    toliman::check(status);
    return true;
}

} // namespace

PeriodFacts::PeriodFacts(const toliman::tracker &tracker, Fit fit)
    : sequential_(NAN), peak_(unknown_peak()), fit_(unknown_peak()) {
    const toliman_period *period = nullptr;
    toliman::check(toliman_track_get_period(tracker.get(), &period));
    count_ = toliman_period_count(period);
    if (!is_known(toliman_period_query_peak(period, &peak_)))
        return;
    toliman::check(toliman_period_query_fap(period, TOLIMAN_FAP_SEQUENTIAL, peak_.log10_residual, &sequential_));
    if (fit == Fit::made)
        is_known(toliman_track_query_fit(tracker.get(), &fit_));
}

void PeriodFacts::add_to(Json &json) const {
    json.set_count("n", count_).set("period", peak_.period).set("period_error_fwhm", peak_.fwhm_error);
    json.set("frequency", peak_.frequency).set("power", peak_.power).set("log10_fap", peak_.log10_fap);
    json.set("log10_fap_sequential", sequential_).set_flag("at_edge", (peak_.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
    if (!std::isfinite(fit_.period)) {
        json.set_null("fit");
        return;
    }
    Json fit;
    fit.set("period", fit_.period).set("period_error", fit_.period_error).set("amplitude", fit_.amplitude);
    fit.set("amplitude_error", fit_.amplitude_error).set("phase", fit_.phase).set("offset", fit_.offset);
    json.set("fit", std::move(fit.set("log10_fap", fit_.log10_fap)));
}

std::string PeriodFacts::text() const {
    char text[200];
    if (!std::isfinite(peak_.log10_fap))
        return "no period yet";
    const toliman_period_peak &best = std::isfinite(fit_.period) ? fit_ : peak_;
    size_t size = static_cast<size_t>(std::snprintf(text, sizeof text, "period %.6g ", best.period));
    if (std::isfinite(best.period_error))
        size += static_cast<size_t>(std::snprintf(text + size, sizeof text - size, "+- %.2g ", best.period_error));
    std::snprintf(text + size, sizeof text - size, "d, log10 FAP %.2f, sequential %.2f", best.log10_fap, sequential_);
    return text;
}

void add_counts(const toliman_track_info &info, Json &json) {
    json.set_count("received", info.received).set_count("accepted", info.accepted);
    json.set_count("outlier", info.outlier).set_count("quarantined", info.quarantined);
    json.set_count("repeated", info.repeated).set_count("rejected", info.rejected);
    Json reasons;
    for (int32_t i = 1; i < TOLIMAN_REASONS; i++)
        reasons.set_count(toliman_track_reason_name(i), info.rejected_by[i]);
    json.set("rejected_by", std::move(reasons));
    json.set_count("expected", info.expected).set_count("missing", info.missing).set_count("dropped", info.dropped);
    json.set_count("sessions", info.sessions);
}

} // namespace cli
