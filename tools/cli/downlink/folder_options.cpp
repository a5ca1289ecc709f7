#include "downlink/folder_options.hpp"

#include <CLI/App.hpp>
#include <algorithm>
#include <tuple>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/text.hpp"
#include "options/command.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

constexpr char kOtherEstimator[] =
    "the weights or the scene differ from those that the folder was created with: give the same ones, or a new folder";

// Two whole numbers from `least` to 65536; an empty text leaves a and b unchanged.
void set_two(const std::string &text, const char *option, char separator, int64_t least, int64_t &a, int64_t &b) {
    int64_t first = 0, second = 0;
    if (text.empty())
        return;
    if (!two_numbers(text, separator, first, second) || std::min(first, second) < least ||
        std::max(first, second) > 65536)
        throw Failure(kExitUsage, std::string(option) + " " + text + ": must be two whole numbers from " +
                                      std::to_string(least) + " to 65536, e.g. " + (least == 0 ? "16,24" : "256x256"));
    a = first;
    b = second;
}

bool uses_same_frames(const toliman_track_options &a, const toliman_track_options &b) {
    const auto frames = [](const toliman_track_options &how) {
        return std::make_tuple(how.rows, how.cols, how.crop_row, how.crop_col, how.bin, how.bit_depth, how.value_limit);
    };
    return frames(a) == frames(b);
}

bool has_same_timing(const toliman_track_options &a, const toliman_track_options &b) {
    return a.stamp == b.stamp && a.exposure_s == b.exposure_s;
}

} // namespace

void FolderOptions::check() const {
    if (weights_.empty() == scene_.empty())
        throw Failure(kExitUsage,
                      std::string("give either --weights or --template") + (scene_.empty() ? "" : ", not both"));
}

Estimator FolderOptions::make_estimator(Progress &progress) const {
    Estimator made;
    if (!weights_.empty()) {
        made.network.emplace(weights_);
        made.rows = made.network->info.rows;
        made.cols = made.network->info.cols;
        return made;
    }
    const Scene scene(scene_, progress);
    made.linear = toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr);
    made.rows = scene.info.rows;
    made.cols = scene.info.cols;
    made.exposure_s = scene.info.exposure_s;
    return made;
}

// Refuses a folder whose setup is neither stored in it nor given.
void FolderOptions::check_setup(const Made &made) const {
    if (!made && !setup_.has_grid())
        throw Failure(kExitUsage, folder_ + ": is new: give --grid F0:DF:NF or --mission-days N");
    if (made && made->nf == 0)
        setup_.check_complete(folder_);
}

// Refuses a pixel type that does not fit the bit depth of the folder's frames: one of the two is likely a mistake.
void FolderOptions::check_depth(const std::string &dtype, const toliman_track_options &made) const {
    const bool wide = dtype == "u32le";
    if (dtype.empty() || bit_depth_ || made.bit_depth == 0 || wide == (made.bit_depth > 16))
        return;
    const std::string depth = std::to_string(made.bit_depth);
    throw Failure(kExitUsage, "--dtype " + dtype + ": the frames of " + folder_ + " have " + depth +
                                  " bits: give --dtype " + (wide ? "u16le" : "u32le") + ", or a new folder; if these " +
                                  dtype + " files also have " + depth + " bits, add --bit-depth " + depth);
}

// The place of the image in a larger frame is never guessed.
void FolderOptions::check_crop(const Estimator &estimator, const toliman_track_options &how) const {
    const int64_t bin = std::max<int64_t>(1, how.bin), rows = bin * estimator.rows, cols = bin * estimator.cols;
    if (crop_.empty() && (how.rows > rows || how.cols > cols))
        throw Failure(kExitUsage, "--shape " + shape_ + ": is larger than the " + shape_text(rows, cols) +
                                      " pixels that are used: give the first of these with --crop ROW,COL");
}

// The options given, with the settings of an existing folder as defaults.
toliman_track_options FolderOptions::track_options(const std::string &dtype, const Estimator &estimator,
                                                   const Made &made, Progress &progress) {
    auto how = made ? *made : toliman::sized<toliman_track_options>();
    how.folder = folder_.c_str();
    if (!made && !dtype.empty()) { // pairs, whose stamps are those of the mission
        how.bit_depth = dtype == "u16le" ? 12 : 32;
        how.stamp = TOLIMAN_FRAME_STAMP_START;
        how.exposure_s = estimator.exposure_s;
    }
    setup_.set(how, progress);
    how.bit_depth = bit_depth_.value_or(how.bit_depth);
    how.bin = bin_.value_or(how.bin);
    how.capacity = capacity_.value_or(how.capacity);
    how.value_limit = value_limit_.value_or(how.value_limit);
    set_two(crop_, "--crop", ',', 0, how.crop_row, how.crop_col);
    set_two(shape_, "--shape", 'x', 1, how.rows, how.cols);
    how.threads = jobs_;
    how.sync = sync_ == "frame" ? TOLIMAN_TRACK_SYNC_FRAME : sync_ == "none" ? TOLIMAN_TRACK_SYNC_NONE : 0;
    how.cae = estimator.network ? estimator.network->cae.get() : nullptr;
    how.linear = estimator.linear.get();
    return how;
}

// What to do if the folder was created with other settings, which the file `field` contains.
std::string FolderOptions::remedy_of(const toliman_track_options &how, const Made &made,
                                     const std::string &field) const {
    const std::string fixed = "these cannot be changed: leave out ";
    if (made && !uses_same_frames(*made, how))
        return fixed + "--shape, --crop, --bin, --bit-depth and --value-limit, or give a new folder";
    if (made && !has_same_timing(*made, how))
        return fixed + "--stamp and --exposure, or give a new folder";
    return field == folder_ + "/setup.tlms" ? "`toliman rebuild " + folder_ + setup_.text() + "`, or give a new folder"
                                            : kOtherEstimator;
}

toliman::tracker FolderOptions::open(const std::string &dtype, Estimator &estimator, Progress &progress) {
    const Made made = made_with(folder_);
    check_setup(made);
    estimator = make_estimator(progress);
    if (made && (made->image_rows != estimator.rows || made->image_cols != estimator.cols))
        throw Failure(kExitUsage, folder_ + ": " + kOtherEstimator);
    if (made)
        check_depth(dtype, *made);
    const toliman_track_options how = track_options(dtype, estimator, made, progress);
    if (!made)
        check_crop(estimator, how);
    try {
        return open_tracker(how, progress);
    } catch (const toliman::error &error) {
        if (error.status() != TOLIMAN_E_MISMATCH && (!made || uses_same_frames(*made, how)))
            throw;
        throw Failure(kExitUsage, std::string(error.what()) + ": " + remedy_of(how, made, error.field()));
    }
}

void FolderOptions::add_to(CLI::App &command) {
    // Not a CLI11 option group of --weights and --template: it would report any mistyped word as a missing one of
    // these.
    add_option(&command, "--weights", weights_, "FILE",
               "weights file of `toliman train`: encode frames by its network");
    add_option(&command, "--template", scene_, "SCENE",
               "instead of --weights: scene file; encode frames by least squares on its derivative image");
    add_option(&command, "--state", folder_, "FOLDER",
               "state folder: ledger, settings and sums; created if it does not exist")
        ->required()
        ->transform(plain);
    setup_.add_to(command);
    add_choice(&command, "--sync", sync_, {"frame", "group", "none"},
               "durability of ledger records: fsync after each record (frame), after 64 records or a second (group, "
               "default), or never (none)");
    command.add_option("--jobs", jobs_,
                       "threads that estimate frames between two updates, default 1; 0: one per processor");
    command
        .add_option("--bit-depth", bit_depth_,
                    "N: a frame with a pixel of 2^N or more is rejected; default 12 for u16le, 32 for u32le")
        ->check(CLI::Range(1, 32));
    add_option(&command, "--shape", shape_, "ROWSxCOLS",
               "size of the frames, ROWSxCOLS; default: that of the scene or weights");
    add_option(&command, "--crop", crop_, "ROW,COL",
               "row and column of the first pixel used, ROW,COL; required for frames larger than the default size");
    command.add_option("--bin", bin_, "N: add up blocks of N x N pixels, default 1")->check(CLI::Range(1, 65536));
    command
        .add_option("--value-limit", value_limit_,
                    "largest absolute value in px, beyond which a frame is an outlier; default 10,000 times the "
                    "Cramer-Rao bound of a frame")
        ->check(CLI::PositiveNumber);
    command.add_option("--capacity", capacity_, "largest number of frames, 24 bytes of memory each, default 2^20")
        ->check(CLI::Range(int64_t{1}, int64_t{1} << 28));
}

} // namespace cli
