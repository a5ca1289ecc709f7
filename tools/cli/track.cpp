// toliman track: frames off the downlink -> the period.
#include <cmath>
#include <cstdio>

#include "command.hpp"
#include "downlink.hpp"
#include "failure.hpp"
#include "scene.hpp"
#include "state_folder.hpp"
#include "tracking.hpp"

namespace cli {

namespace {

struct Options {
    std::string weights, scene, state, grid, clock, sync = "group", crop, shape, frames, leap_seconds;
    std::optional<double> mission_days, value_limit;
    std::optional<uint32_t> bit_depth;
    std::optional<int64_t> bin, capacity, epoch;
    size_t every = 1;
    unsigned jobs = 1;
    bool strict = false;
    DownlinkOptions downlink;
};

constexpr char kDescription[] = R"(Period from frames as they come off the downlink: late, twice, out of order, damaged.

Examples:
  toliman track --weights w.tlmw --state mission --mission-days 1095 --dtype u16le downlink/
  toliman track --weights w.tlmw --state mission --dtype u16le --follow downlink/
  ls passes/*_meta.jsonl | toliman track --template scene.json --state mission --dtype u32le --grid 1e-3:1e-4:5000 -
  toliman track --template scene.json --state lab --mission-days 100 --cadence 86400 cube.npy
  toliman track --template scene.json --state sky --mission-days 1095 2029-*.fits
  toliman track --template scene.json --state shard_3 --frames 3000:4000 --mission-days 1095 --dtype u32le downlink/
  toliman status mission

A frame is known by session, frame id and region. It comes as a raw pair (X_frames.bin or X_meta.jsonl, the other beside
it), in a folder of pairs, in .npy or FITS files, or by names of these, one a line on standard input (-). The state folder
holds a ledger of every frame, so that the same command goes on where it was stopped, and any order of arrival gives the
same bits. A duplicate is ignored; a frame that comes with two contents is quarantined and taken back.

On standard output stand a line of JSON a frame, printed once it is safe on the disk, and updates of the period. Damaged
frames, bad lines, short files and jumps of the clock are named and counted on both outputs and end nothing; with --strict
the exit code is then 4. Where the sizes of a pair do not add up, only frames before its first bad line count.

FITS files tell their time, mid-exposure, by the first of MJD-AVG, DATE-AVG, MJD-BEG + XPOSURE/2, MJD-OBS + EXPTIME/2 and
DATE-OBS + EXPTIME/2, in the scale TIMESYS: UTC (also if it is missing), TAI, TT or GPS. It becomes TAI in ns since
1970-01-01T00:00:00 TAI, for folders without --clock. It is that of a cube's first frame; the others follow as the table
FRAMES of `toliman simulate` says, or by --cadence. A file without these keywords has the times of that table or, from 0
on, of --cadence. What a file says goes before --cadence; the rule is told for each file. FRAME1 is the number of a file's
first frame, default 0: with it many files may have one --session.

A new folder needs --grid or --mission-days; one that exists remembers grid, clock, shape and limits.)";

// "16,24" or "256x256".
void two_numbers(const std::string &text, const char *option, const char *form, int64_t least, int64_t &a, int64_t &b) {
    if (text.empty())
        return;
    long long first = 0, second = 0;
    char rest = '\0';
    if (std::sscanf(text.c_str(), form, &first, &second, &rest) != 2 || first < least || second < least ||
        first > 65536 || second > 65536)
        throw Failure(kExitUsage, std::string(option) + " " + text + ": must be two whole numbers from " +
                                      std::to_string(least) + " to 65536, as in the examples of --help");
    a = first;
    b = second;
}

// "A:B", whole numbers.
FrameIds frame_ids(const std::string &text) {
    if (text.empty())
        return {};
    long long first = 0, end = 0;
    char rest = '\0';
    if (std::sscanf(text.c_str(), "%lld:%lld%c", &first, &end, &rest) != 2 || first >= end)
        throw Failure(kExitUsage, "--frames " + text + ": must be A:B, two frame ids of which the first is less");
    return {first, end};
}

// The estimator, which must outlive the tracker.
struct Estimator {
    Estimator(const Options &options, Progress &progress) {
        if (!options.weights.empty()) {
            cae = toliman::make<toliman::autoencoder>(toliman_cae_load_file, options.weights.c_str(), nullptr);
            return;
        }
        const Scene scene(options.scene, progress);
        linear = toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr);
    }
    toliman::autoencoder cae;
    toliman::linear_estimator linear;
};

FrequencyGrid grid_asked(const Options &options) {
    if (!options.grid.empty())
        return grid_of(options.grid);
    try {
        return grid_of_span(1, *options.mission_days);
    } catch (const Failure &failure) {
        throw Failure(failure.code(), std::string("--mission-days: ") + failure.what());
    }
}

// What is asked for, upon what an existing folder was made with.
toliman_track_options track_options(const Options &options, const std::vector<int64_t> &clock) {
    toliman_track_options how;
    toliman_track_options_init(&how);
    const std::optional<toliman_track_options> made = made_with(options.state);
    if (made)
        how = *made;
    if (made && made->nf == 0 && clock.empty())
        throw Failure(kExitUsage, options.state + ": setup.tlms, which had grid and clock, is lost: needs --clock and "
                                                  "--grid or --mission-days");
    how.folder = options.state.c_str();
    if (!options.grid.empty() || options.mission_days)
        set_grid(grid_asked(options), how);
    else if (how.nf == 0)
        throw Failure(kExitUsage, options.state +
                                      (made ? ": setup.tlms, which had grid and clock, is lost" : ": is new") +
                                      ": needs --grid F0:DF:NF or --mission-days N");
    if (!made && !options.downlink.dtype.empty())
        how.bit_depth = options.downlink.dtype == "u16le" ? 12 : 32;
    how.bit_depth = options.bit_depth.value_or(how.bit_depth);
    how.bin = options.bin.value_or(how.bin);
    how.capacity = options.capacity.value_or(how.capacity);
    how.value_limit = options.value_limit.value_or(how.value_limit);
    how.time_offset_ns = options.epoch.value_or(how.time_offset_ns);
    two_numbers(options.crop, "--crop", "%lld,%lld%c", 0, how.crop_row, how.crop_col);
    two_numbers(options.shape, "--shape", "%lldx%lld%c", 1, how.rows, how.cols);
    how.threads = options.jobs;
    how.sync = options.sync == "frame" ? TOLIMAN_SYNC_FRAME : options.sync == "none" ? TOLIMAN_SYNC_NONE : 0;
    set_clock(clock, how);
    return how;
}

void track(Options &options, Progress &progress) {
    DownlinkOptions &downlink = options.downlink;
    check_inputs(downlink);
    const FrameIds frames = frame_ids(options.frames);
    downlink.leap_seconds = LeapSeconds(options.leap_seconds);
    const std::vector<int64_t> clock = read_clock(options.clock);
    toliman_track_options how = track_options(options, clock);
    const Estimator estimator(options, progress);
    how.cae = estimator.cae.get();
    how.linear = estimator.linear.get();
    toliman::tracker tracker = open_tracker(how);
    const std::optional<toliman_track_options> made = made_with(options.state);
    downlink.rows = static_cast<size_t>(made->rows);
    downlink.cols = static_cast<size_t>(made->cols);
    downlink.clock = has_clock(tracker);
    Tracking tracking(std::move(tracker), {options.every, options.jobs == 0 ? 64 : options.jobs, frames}, progress);
    try {
        Downlink(downlink, tracking).read();
    } catch (...) {
        tracking.rescue();
        throw;
    }
    tracking.end();
    if (options.strict && tracking.troubles() > 0)
        throw Failure(kExitRejected, options.state + ": " + std::to_string(tracking.troubles()) +
                                         " frames or inputs were not as they should be");
}

} // namespace

void add_track(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("track", kDescription);
    auto options = std::make_shared<Options>();
    DownlinkOptions &downlink = options->downlink;
    CLI::Option_group *estimator = command->add_option_group("estimator");
    estimator->add_option("--weights", options->weights, "weights file of `toliman train`");
    estimator->add_option("--template", options->scene, "scene file: least squares on its derivative image");
    estimator->require_option(1);
    command
        ->add_option("--state", options->state, "folder of the ledger and what is made of it, made unless it is there")
        ->required();
    CLI::Option *grid = command->add_option("--grid", options->grid, "F0:DF:NF, frequencies in cycles a day");
    command->add_option("--mission-days", options->mission_days, "the grid of `run` for N days of a frame a day")
        ->check(CLI::Range(4.0, 1e6))
        ->excludes(grid);
    command->add_option("--clock", options->clock,
                        "CSV of pairs camera_ns,tai_ns, or camera, the default: its time is TAI");
    command->add_option("--epoch", options->epoch, "TAI in ns that is time 0 of the phase, default 0");
    command->add_option("--sync", options->sync, "lines to the disk each (frame), in groups (default), or none")
        ->check(CLI::IsMember({"frame", "group", "none"}));
    command->add_option("--every", options->every, "an update after so many accepted frames, default 1")
        ->check(CLI::Range(1u, 1000000000u));
    command->add_option("--jobs", options->jobs, "threads that estimate the frames between two updates, default 1");
    command->add_option("--dtype", downlink.dtype, "of raw pairs: u16le or u32le")
        ->check(CLI::IsMember({"u16le", "u32le"}));
    command->add_option("--bit-depth", options->bit_depth, "pixels of 2^N or more reject a frame; u16le 12, u32le 32")
        ->check(CLI::Range(1, 32));
    command->add_option("--shape", options->shape, "ROWSxCOLS of frames, where --crop leaves some out at the end");
    command->add_option("--crop", options->crop, "ROW,COL of the first pixel taken, default 0,0");
    command->add_option("--bin", options->bin, "so many pixels a side are added up, default 1")
        ->check(CLI::Range(1, 65536));
    command->add_option("--value-limit", options->value_limit, "values further from 0 are outliers; 10,000 sigma")
        ->check(CLI::PositiveNumber);
    command->add_option("--capacity", options->capacity, "frames at most, 24 bytes each, default 2^20")
        ->check(CLI::Range(int64_t{1}, int64_t{1} << 28));
    command->add_option("--frames", options->frames, "A:B, only frames with ids from A to B - 1, of a shard");
    command
        ->add_option("--cadence", downlink.cadence,
                     "seconds from frame to frame of .npy and FITS files, unless they tell it")
        ->check(CLI::PositiveNumber);
    command->add_option("--session", downlink.session, "of .npy and FITS files, default their names");
    command->add_option("--leap-seconds", options->leap_seconds,
                        "leap-seconds.list of the IERS, default the table built in");
    command->add_flag("--follow", downlink.follow, "go on as folders and pairs grow, until a signal");
    command->add_flag("--strict", options->strict, "exit code 4 if anything was damaged or quarantined");
    command->add_option("INPUT", downlink.inputs, "pairs, folders, .npy and FITS files; - reads names")->required();
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            track(*options, progress);
        };
    });
}

} // namespace cli
