// toliman track: frames from the spacecraft, in any order, to the period.
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

// "16,24" or "256x256".
void two_numbers(const std::string &text, const char *option, const char *form, int64_t least, int64_t &a, int64_t &b) {
    if (text.empty())
        return;
    long long first = 0, second = 0;
    char rest = '\0';
    if (std::sscanf(text.c_str(), form, &first, &second, &rest) != 2 || first < least || second < least ||
        first > 65536 || second > 65536)
        throw Failure(kExitUsage, std::string(option) + " " + text + ": must be two whole numbers from " +
                                      std::to_string(least) + " to 65536, e.g. " + (least == 0 ? "16,24" : "256x256"));
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
        throw Failure(kExitUsage, "--frames " + text + ": must be A:B, two frame ids with A < B");
    return {first, end};
}

// The estimator; it must outlive the tracker.
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
    int64_t rows, cols; // of its images
};

constexpr char kOtherEstimator[] =
    "the weights or the scene differ from those that the folder was created with: give the same ones, or "
    "a new folder";

// Refuses a folder whose grid or clock is neither stored in it nor given.
void check_setup(const Options &options, const std::optional<toliman_track_options> &made) {
    if (made && made->nf > 0)
        return;
    const std::string lost = made ? ": setup.tlms with grid and clock is missing" : ": is new";
    if (made && !options.setup.has_clock())
        throw Failure(kExitUsage, options.state + lost + ": give --clock, and --grid or --mission-days");
    if (!options.setup.has_grid())
        throw Failure(kExitUsage, options.state + lost + ": give --grid F0:DF:NF or --mission-days N");
}

// Refuses a pixel type that does not fit the bit depth of the folder's frames: one of the two is likely a mistake.
void check_depth(const Options &options, const toliman_track_options &made) {
    const std::string &dtype = options.downlink.dtype;
    const bool wide = dtype == "u32le";
    if (dtype.empty() || options.bit_depth || made.bit_depth == 0 || wide == (made.bit_depth > 16))
        return;
    const std::string depth = std::to_string(made.bit_depth);
    throw Failure(kExitUsage, "--dtype " + dtype + ": the frames of " + options.state + " have " + depth +
                                  " bits: give --dtype " + (wide ? "u16le" : "u32le") + ", or a new folder; if these " +
                                  dtype + " files also have " + depth + " bits, add --bit-depth " + depth);
}

// The place of the image in a larger frame is never guessed.
void check_crop(const Options &options, const Estimator &estimator, const toliman_track_options &how) {
    const int64_t bin = std::max<int64_t>(1, how.bin), rows = bin * estimator.rows, cols = bin * estimator.cols;
    if (options.crop.empty() && (how.rows > rows || how.cols > cols))
        throw Failure(kExitUsage, "--shape " + options.shape + ": is larger than the " + std::to_string(rows) + "x" +
                                      std::to_string(cols) +
                                      " pixels that are used: give the first of these with "
                                      "--crop ROW,COL");
}

// The options given, with the settings of an existing folder as defaults.
toliman_track_options track_options(Options &options, const Estimator &estimator,
                                    const std::optional<toliman_track_options> &made, Progress &progress) {
    auto how = toliman::sized<toliman_track_options>();
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

bool uses_same_frames(const toliman_track_options &a, const toliman_track_options &b) {
    const auto frames = [](const toliman_track_options &how) {
        return std::make_tuple(how.rows, how.cols, how.crop_row, how.crop_col, how.bin, how.bit_depth, how.value_limit);
    };
    return frames(a) == frames(b);
}

// What to do if the folder was created with other settings, which the file `field` contains.
std::string remedy_of(const Options &options, bool same_frames, const std::string &field) {
    if (!same_frames)
        return "these cannot be changed: leave out --shape, --crop, --bin, --bit-depth and --value-limit, or give a "
               "new folder";
    return field == options.state + "/setup.tlms"
               ? "`toliman rebuild " + options.state + options.setup.text() + "`, or give a new folder"
               : kOtherEstimator;
}

toliman::tracker open_folder(const Options &options, const toliman_track_options &how,
                             const std::optional<toliman_track_options> &made, Progress &progress) {
    try {
        return open_tracker(how, progress);
    } catch (const toliman::error &error) {
        const bool same_frames = made && uses_same_frames(*made, how);
        if (error.status() != TOLIMAN_E_MISMATCH && (!made || same_frames))
            throw;
        throw Failure(kExitUsage, std::string(error.what()) + ": " + remedy_of(options, same_frames, error.field()));
    }
}

void track(Options &options, Progress &progress) {
    DownlinkOptions &downlink = options.downlink;
    options.state = plain(options.state);
    if (options.weights.empty() == options.scene.empty())
        throw Failure(kExitUsage,
                      std::string("give either --weights or --template") + (options.scene.empty() ? "" : ", not both"));
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
        throw Failure(
            kExitRejected,
            options.state + ": " + std::to_string(tracking.troubles()) +
                " frames or inputs were damaged or quarantined, as listed in the output; the others were processed");
}

} // namespace

void add_track(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "track");
    auto options = std::make_shared<Options>();
    DownlinkOptions &downlink = options->downlink;
    // Not a CLI11 option group of --weights and --template: it would report any mistyped word as a missing one of
    // these.
    add_option(command, "--weights", options->weights, "FILE",
               "weights file of `toliman train`: encode frames by its network");
    add_option(command, "--template", options->scene, "SCENE",
               "instead of --weights: scene file; encode frames by least squares on its derivative image");
    add_option(command, "--state", options->state, "FOLDER",
               "state folder: ledger, settings and sums; created if it does not exist")
        ->required();
    options->setup.add_to(*command);
    add_choice(command, "--sync", options->sync, {"frame", "group", "none"},
               "durability of ledger records: fsync after each record (frame), after 64 records or a second "
               "(group, default), or never (none)");
    command->add_option("--every", options->every, "accepted frames between two updates of the period, default 1")
        ->check(CLI::Range(1u, 1000000000u));
    command->add_option("--jobs", options->jobs,
                        "threads that estimate frames between two updates, default 1; 0: one per processor");
    add_choice(command, "--dtype", downlink.dtype, {"u16le", "u32le"},
               "pixel type of raw pairs, required for them: u16le or u32le");
    command
        ->add_option("--bit-depth", options->bit_depth,
                     "N: a frame with a pixel of 2^N or more is rejected; default 12 for u16le, 32 for u32le")
        ->check(CLI::Range(1, 32));
    add_option(command, "--shape", options->shape, "ROWSxCOLS",
               "size of the frames, ROWSxCOLS; default: that of the scene or weights");
    add_option(command, "--crop", options->crop, "ROW,COL",
               "row and column of the first pixel used, ROW,COL; required for frames larger than the default size");
    command->add_option("--bin", options->bin, "N: add up blocks of N x N pixels, default 1")
        ->check(CLI::Range(1, 65536));
    command
        ->add_option("--value-limit", options->value_limit,
                     "largest absolute value in px, beyond which a frame is an outlier; default 10,000 times the "
                     "Cramer-Rao bound of a frame")
        ->check(CLI::PositiveNumber);
    command
        ->add_option("--capacity", options->capacity, "largest number of frames, 24 bytes of memory each, default 2^20")
        ->check(CLI::Range(int64_t{1}, int64_t{1} << 28));
    add_option(command, "--frames", options->frames, "RANGE",
               "A:B: use only frames with ids from A to B - 1 (a shard); default all");
    command
        ->add_option("--cadence", downlink.cadence,
                     "seconds from frame to frame of .npy and FITS files; required if the files contain no times")
        ->check(CLI::PositiveNumber);
    add_option(command, "--session", downlink.session, "NAME",
               "session name for .npy and FITS files, default their file names");
    add_option(command, "--leap-seconds", options->leap_seconds, "FILE",
               "leap-seconds.list of the IERS, default the table of ERFA");
    command->add_flag("--follow", downlink.follow,
                      "wait for folders and pairs to grow, until stopped by SIGINT or SIGTERM");
    command->add_flag("--strict", options->strict, "exit with code 4 if anything was damaged or quarantined");
    add_option(command, "INPUT", downlink.inputs, "",
               "raw pairs, folders of pairs, .npy and FITS files; - reads their names from standard input")
        ->required();
    set_action(*command, context, options, track);
}

} // namespace cli
