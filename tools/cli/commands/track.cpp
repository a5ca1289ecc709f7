// toliman track: frames off the downlink -> the period.
#include <algorithm>
#include <cstdio>
#include <tuple>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "downlink/downlink.hpp"
#include "downlink/setup_options.hpp"
#include "downlink/state_folder.hpp"
#include "downlink/tracking.hpp"
#include "frames/network.hpp"
#include "options/command.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

struct Options {
    std::string weights, scene, state, sync = "group", crop, shape, frames, leap_seconds;
    SetupOptions setup;
    std::optional<double> value_limit;
    std::optional<uint32_t> bit_depth;
    std::optional<int64_t> bin, capacity;
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
1970-01-01T00:00:00 TAI, for folders without --clock. Without XPOSURE or EXPTIME a time is taken as mid-exposure, with a
warning. It is that of a cube's first frame; the others follow as the table FRAMES of `toliman simulate` says, or by
--cadence. A file without these keywords has the times of that table, or those of its frames' numbers times --cadence.
Times in a file override --cadence; stderr says for each file which rule was used. FRAME1 is the number of a file's first frame,
default 0: with it many files may have one --session. .npy files have no FRAME1: each begins at time 0. A warning tells
where files have the same times by --cadence.

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
            network.emplace(options.weights);
            rows = network->info.rows;
            cols = network->info.cols;
            return;
        }
        const Scene scene(options.scene, progress);
        linear = toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr);
        rows = scene.info.rows;
        cols = scene.info.cols;
    }
    std::optional<Network> network;
    toliman::linear_estimator linear;
    int64_t rows, cols; // of the images it takes
};

constexpr char kOtherEstimator[] =
    "the weights or the scene are not those that the folder was made with: give these, or "
    "a new folder";

// Grid and clock that neither the command nor the folder tells.
void check_setup(const Options &options, const std::optional<toliman_track_options> &made) {
    if (made && made->nf > 0)
        return;
    const std::string lost = made ? ": setup.tlms, which had grid and clock, is lost" : ": is new";
    if (made && !options.setup.has_clock())
        throw Failure(kExitUsage, options.state + lost + ": needs --clock and --grid or --mission-days");
    if (!options.setup.has_grid())
        throw Failure(kExitUsage, options.state + lost + ": needs --grid F0:DF:NF or --mission-days N");
}

// Raw frames that the folder would take for others.
void check_depth(const Options &options, const toliman_track_options &made) {
    const std::string &dtype = options.downlink.dtype;
    const bool wide = dtype == "u32le";
    if (dtype.empty() || options.bit_depth || made.bit_depth == 0 || wide == (made.bit_depth > 16))
        return;
    const std::string depth = std::to_string(made.bit_depth);
    throw Failure(kExitUsage, "--dtype " + dtype + ": " + options.state + " holds frames of " + depth +
                                  " bits: give --dtype " + (wide ? "u16le" : "u32le") + ", or a new folder; if these " +
                                  dtype + " files have " + depth + " bits too, add --bit-depth " + depth);
}

// Where in a larger frame the image is has to be said.
void check_crop(const Options &options, const Estimator &estimator, const toliman_track_options &how) {
    const int64_t bin = std::max<int64_t>(1, how.bin), rows = bin * estimator.rows, cols = bin * estimator.cols;
    if (options.crop.empty() && (how.rows > rows || how.cols > cols))
        throw Failure(kExitUsage, "--shape " + options.shape + ": is larger than the " + std::to_string(rows) + "x" +
                                      std::to_string(cols) +
                                      " pixels that are taken of it: needs --crop ROW,COL, the "
                                      "first of them");
}

// What is asked for, upon what an existing folder was made with.
toliman_track_options track_options(Options &options, const Estimator &estimator,
                                    const std::optional<toliman_track_options> &made, Progress &progress) {
    toliman_track_options how;
    toliman_track_options_init(&how, sizeof how);
    if (made)
        how = *made;
    if (made && (made->image_rows != estimator.rows || made->image_cols != estimator.cols))
        throw Failure(kExitUsage, options.state + ": " + kOtherEstimator);
    how.folder = options.state.c_str();
    options.setup.set(how, progress);
    if (made)
        check_depth(options, *made);
    else if (!options.downlink.dtype.empty())
        how.bit_depth = options.downlink.dtype == "u16le" ? 12 : 32;
    how.bit_depth = options.bit_depth.value_or(how.bit_depth);
    how.bin = options.bin.value_or(how.bin);
    how.capacity = options.capacity.value_or(how.capacity);
    how.value_limit = options.value_limit.value_or(how.value_limit);
    two_numbers(options.crop, "--crop", "%lld,%lld%c", 0, how.crop_row, how.crop_col);
    two_numbers(options.shape, "--shape", "%lldx%lld%c", 1, how.rows, how.cols);
    if (!made)
        check_crop(options, estimator, how);
    how.threads = options.jobs;
    how.sync = options.sync == "frame"  ? TOLIMAN_TRACK_SYNC_FRAME
               : options.sync == "none" ? TOLIMAN_TRACK_SYNC_NONE
                                        : 0;
    how.cae = estimator.network ? estimator.network->cae.get() : nullptr;
    how.linear = estimator.linear.get();
    return how;
}

bool takes_same_frames(const toliman_track_options &a, const toliman_track_options &b) {
    const auto frames = [](const toliman_track_options &how) {
        return std::make_tuple(how.rows, how.cols, how.crop_row, how.crop_col, how.bin, how.bit_depth, how.value_limit);
    };
    return frames(a) == frames(b);
}

// What to do where the folder was made with something else, as the file `field` has it.
std::string way_out(const Options &options, bool same_frames, const std::string &field) {
    if (!same_frames)
        return "these stay as they are: leave out --shape, --crop, --bin, --bit-depth and --value-limit, or give a new "
               "folder";
    return field == options.state + "/setup.tlms"
               ? "`toliman rebuild " + options.state + options.setup.text() + "`, or give a new folder"
               : kOtherEstimator;
}

toliman::tracker open_folder(const Options &options, const toliman_track_options &how,
                             const std::optional<toliman_track_options> &made, Progress &progress) {
    try {
        return open_tracker(how, progress);
    } catch (const toliman::error &error) {
        const bool same_frames = made && takes_same_frames(*made, how);
        if (error.status() != TOLIMAN_E_MISMATCH && (!made || same_frames))
            throw;
        throw Failure(kExitUsage, std::string(error.what()) + ": " + way_out(options, same_frames, error.field()));
    }
}

void track(Options &options, Progress &progress) {
    DownlinkOptions &downlink = options.downlink;
    options.state = plain(options.state);
    if (options.weights.empty() == options.scene.empty())
        throw Failure(kExitUsage, std::string("needs either --weights or --template") +
                                      (options.scene.empty() ? "" : ", both are given"));
    check_inputs(downlink);
    const FrameIds frames = frame_ids(options.frames);
    downlink.leap_seconds = LeapSeconds(options.leap_seconds);
    const std::optional<toliman_track_options> before = made_with(options.state);
    check_setup(options, before);
    const Estimator estimator(options, progress);
    const std::string unused = exists(options.state) ? "" : options.state;
    toliman::tracker tracker =
        open_folder(options, track_options(options, estimator, before, progress), before, progress);
    const std::optional<toliman_track_options> made = made_with(options.state);
    downlink.rows = static_cast<size_t>(made->rows);
    downlink.cols = static_cast<size_t>(made->cols);
    downlink.clock = !clock_of(tracker).empty();
    const size_t jobs = options.jobs == 0 ? 64 : options.jobs;
    Tracking tracking(std::move(tracker), {options.every, jobs, frames, made->rows, made->cols, unused}, progress);
    try {
        Downlink(downlink, tracking).read();
    } catch (...) {
        tracking.rescue();
        throw;
    }
    tracking.end();
    if (options.strict && tracking.troubles() > 0)
        throw Failure(kExitRejected,
                      options.state + ": " + std::to_string(tracking.troubles()) +
                          " frames or inputs were not as they should be; the good ones are in, and status counts all");
}

} // namespace

void add_track(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("track", kDescription);
    auto options = std::make_shared<Options>();
    DownlinkOptions &downlink = options->downlink;
    // An option group would have a wrong word anywhere blamed on these two.
    command->add_option("--weights", options->weights, "weights file of `toliman train`");
    command->add_option("--template", options->scene,
                        "or, instead of weights, a scene file: least squares on its derivative image");
    command
        ->add_option("--state", options->state, "folder of the ledger and what is made of it, made unless it is there")
        ->required();
    options->setup.add_to(*command);
    command
        ->add_option("--sync", options->sync,
                     "bring lines to the disk each (frame), by 64 or a second (group, default), or leave it to the "
                     "system (none)")
        ->check(CLI::IsMember({"frame", "group", "none"}));
    command->add_option("--every", options->every, "an update after so many accepted frames, default 1")
        ->check(CLI::Range(1u, 1000000000u));
    command->add_option("--jobs", options->jobs,
                        "threads that estimate the frames between two updates, default 1; 0: one a processor");
    command->add_option("--dtype", downlink.dtype, "of raw pairs, which need it: u16le or u32le")
        ->check(CLI::IsMember({"u16le", "u32le"}));
    command
        ->add_option("--bit-depth", options->bit_depth,
                     "pixels of 2^N or more reject a frame; default 12 of u16le, 32 of u32le")
        ->check(CLI::Range(1, 32));
    command->add_option("--shape", options->shape, "ROWSxCOLS of frames, default as many as the scene or weights take");
    command->add_option("--crop", options->crop, "ROW,COL of the first pixel taken, default 0,0");
    command->add_option("--bin", options->bin, "so many pixels a side are added up, default 1")
        ->check(CLI::Range(1, 65536));
    command
        ->add_option("--value-limit", options->value_limit,
                     "px: values further from 0 are outliers; default 10,000 times the bound of a frame")
        ->check(CLI::PositiveNumber);
    command->add_option("--capacity", options->capacity, "frames at most, 24 bytes each, default 2^20")
        ->check(CLI::Range(int64_t{1}, int64_t{1} << 28));
    command->add_option("--frames", options->frames,
                        "A:B, only frames with ids from A to B - 1, of a shard; default all");
    command
        ->add_option("--cadence", downlink.cadence,
                     "s from frame to frame of .npy and FITS files, needed unless they tell it")
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
