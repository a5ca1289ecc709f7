#include "downlink/setup_options.hpp"

#include <charconv>

#include "downlink/state_folder.hpp"
#include "options/command.hpp"
#include "scenes/dates.hpp"
#include "scenes/leap_seconds.hpp"
#include "scenes/sky_times.hpp"
#include "series/periodogram.hpp"

namespace cli {

namespace {

// "F0:DF:NF", cycles per day.
FrequencyGrid grid_of(const std::string &text) {
    FrequencyGrid grid = {};
    long long nf = 0;
    char rest = '\0';
    if (std::sscanf(text.c_str(), "%lf:%lf:%lld%c", &grid.f0, &grid.df, &nf, &rest) != 3)
        throw Failure(kExitUsage, "--grid " + text + ": must be F0:DF:NF in cycles per day, e.g. 0.001:0.0001:5000");
    grid.nf = nf;
    if (!(grid.f0 >= 0) || !(grid.df > 0) || nf < 1 || nf > (1 << 26) || !std::isfinite(grid.f0 + grid.df))
        throw Failure(kExitUsage, "--grid " + text + ": must be F0 >= 0, DF > 0 and 1 <= NF <= 2^26");
    return grid;
}

// TAI in ns as a whole number, or a date.
int64_t epoch_of(const std::string &text, const std::string &leap_seconds) {
    int64_t ns = 0;
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ns);
    if (error == std::errc() && end == text.data() + text.size())
        return ns;
    if (number_of(text, number))
        throw Failure(kExitUsage, "--epoch " + text + ": must be a whole number, TAI in ns, or a date of UTC");
    return read_time("--epoch", text, TOLIMAN_INGEST_SCALE_UTC, LeapSeconds(leap_seconds).rows);
}

double chi_limit_of(const std::string &text) {
    double limit = -1;
    if (text != "median" && !(number_of(text, limit) && limit > 0 && std::isfinite(limit)))
        throw Failure(kExitUsage, "--chi-limit " + text + ": must be a number above 0, or median");
    return limit;
}

// Pairs camera_ns,tai_ns, one after the other; 0,0 for "camera", and none for "".
std::vector<int64_t> read_clock(const std::string &path, Progress &progress) {
    if (path.empty())
        return {};
    if (path == "camera")
        return {0, 0};
    size_t points = 0;
    toliman::check_asked(toliman_ingest_read_clock(path.c_str(), nullptr, 0, &points, nullptr, nullptr));
    std::vector<int64_t> clock(2 * points);
    toliman::check(toliman_ingest_read_clock(path.c_str(), clock.data(), points, &points, Progress::log, &progress));
    clock.resize(2 * points);
    return clock;
}

// The system of a folder, JSON text.
std::string system_of(const std::string &folder, Progress &progress) {
    const toliman::tracker tracker = open_tracker(state_to_read(folder), progress);
    return info_of(tracker).system;
}

} // namespace

void SetupOptions::add_to(CLI::App &command) {
    CLI::Option *grid = add_option(&command, "--grid", grid_, "GRID");
    command.add_option("--mission-days", mission_days_)->check(CLI::Range(4.0, 1e6))->excludes(grid);
    command.add_option("--trend", trend_)->check(CLI::Range(0, 8));
    add_option(&command, "--chi-limit", chi_limit_, "LIMIT");
    add_option(&command, "--clock", clock_, "FILE");
    add_option(&command, "--epoch", epoch_, "TIME");
    add_choice(&command, "--stamp", stamp_, {std::begin(kStamps), std::end(kStamps)});
    command.add_option("--exposure", exposure_s_)->check(CLI::Range(0.0, 1e9));
}

void SetupOptions::set(toliman_track_options &how, Progress &progress) {
    if (has_grid()) {
        const FrequencyGrid grid = grid_.empty() ? grid_of_days(*mission_days_) : grid_of(grid_);
        how.grid.f0 = grid.f0;
        how.grid.df = grid.df;
        how.grid.nf = grid.nf;
        how.grid.flags = TOLIMAN_PERIOD_DOUBLE_LIMB; // as `run` and `period`
    }
    if (trend_)
        set_trend(how, *trend_);
    if (!chi_limit_.empty())
        how.limits.chi_square = chi_limit_of(chi_limit_);
    if (epoch_)
        how.grid.time_offset_ns = epoch_of(*epoch_, leap_seconds_);
    if (!stamp_.empty())
        how.frames.stamp = stamp_of(stamp_);
    how.frames.exposure_s = exposure_s_.value_or(how.frames.exposure_s);
    pairs_ = read_clock(clock_, progress);
    how.clock.pairs = pairs_.data();
    how.clock.count = pairs_.size() / 2;
}

void SetupOptions::compare(const SceneDefaults &scene, int64_t time_zero_ns, const toliman_track_options &how,
                           Notes &notes) const {
    if (epoch_ && time_zero_ns != 0 && how.grid.time_offset_ns != time_zero_ns)
        notes.push_back("--epoch " + *epoch_ + ": instead of binary.date of " + scene.path + ", " +
                        date_text(time_zero_ns) + " TAI");
    if (exposure_s_ && scene.exposure_s > 0 && *exposure_s_ != scene.exposure_s)
        notes.push_back(formatted("--exposure %g: instead of cadence.exposure_s of ", *exposure_s_) + scene.path +
                        formatted(", %g s", scene.exposure_s));
}

void set_trend(toliman_track_options &how, int32_t order) {
    how.grid.trend = order > 0 ? order : -1;
    how.grid.trend_start = how.grid.trend_end = 0; // the span of the grid
}

void SetupOptions::check_complete(const std::string &folder) const {
    if (!is_complete())
        throw Failure(kExitUsage, folder + ": setup.tlms with grid and clock is missing: give --clock, and --grid or "
                                           "--mission-days, and --stamp, with --exposure if it was known");
}

std::string SetupOptions::text() const {
    return (grid_.empty() ? "" : " --grid " + grid_) +
           (mission_days_ ? formatted(" --mission-days %.17g", *mission_days_) : "") +
           (trend_ ? " --trend " + std::to_string(*trend_) : "") +
           (chi_limit_.empty() ? "" : " --chi-limit " + chi_limit_) + (epoch_ ? " --epoch " + *epoch_ : "") +
           (clock_.empty() ? "" : " --clock " + clock_);
}

void ReferenceOptions::add_to(CLI::App &command) {
    add_option(&command, "--system", system_, "SYSTEM");
    observer_.add_to(command, ObserverOptions::Times::given_elsewhere);
    add_option(&command, "--plate-scale", plate_scale_, "ARCSEC");
    command.add_option("--scale-sigma", scale_sigma_)->check(CLI::Range(0.0, 0.999));
}

void ReferenceOptions::check() const {
    observer_.check();
    if (plate_scale_)
        plate_scale_of(plate_scale_, 0);
}

void ReferenceOptions::use_scene(const SceneDefaults &scene, const std::optional<toliman_track_options> &made,
                                 Notes &notes) {
    const bool is_reduced = made && made->reduction.plate_scale_arcsec > 0;
    if (!given() && made && !is_reduced)
        return;
    observer_.use_scene(scene, notes);
    has_observer_ = scene.has_observer;
    system_ = system_or_that_of(scene, system_, !is_reduced && (observer_.given() || has_observer_), notes);
}

void ReferenceOptions::set(toliman_track_options &how, const std::optional<toliman_track_options> &made,
                           Progress &progress) {
    const bool is_reduced = made && made->reduction.plate_scale_arcsec > 0;
    if (!given() && !is_reduced)
        return;
    if (system_.empty() && !is_reduced)
        throw Failure(kExitUsage, (observer_.given() ? "--observer and --altitude"
                                   : plate_scale_    ? "--plate-scale"
                                                     : "--scale-sigma") +
                                      std::string(": need --system"));
    if (system_.empty() && !observer_.given() && !has_observer_)
        throw Failure(kExitUsage,
                      std::string(how.folder) +
                          ": its separations are reduced: give the orbit of the spacecraft, --observer FILE");
    sky_ = observer_.predictor(system_.empty() ? system_of(how.folder, progress) : system_, 0, progress);
    how.reduction.sky = sky_.get();
    if (plate_scale_)
        how.reduction.plate_scale_arcsec = plate_scale_of(plate_scale_, 0);
    how.reduction.scale_sigma = scale_sigma_.value_or(how.reduction.scale_sigma);
}

std::string ReferenceOptions::text() const {
    return (system_.empty() ? "" : " --system " + system_) + observer_.options() +
           (plate_scale_ ? formatted(" --plate-scale %.17g", *plate_scale_) : "") +
           (scale_sigma_ ? formatted(" --scale-sigma %.17g", *scale_sigma_) : "");
}

std::string ReferenceOptions::orbit() const {
    return sky_ ? observer_.orbit(sky_.get()) : "";
}

std::string ReferenceOptions::coverage() const {
    return sky_ && observer_.is_file() ? observer_.coverage(sky_.get()) : "";
}

} // namespace cli
