#include "downlink/folder_options.hpp"

#include <CLI/App.hpp>
#include <tuple>

#include "downlink/ledger_report.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

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

constexpr int32_t kTrendOfMovingStars = 4; // the error of an orbit leaves 0.06 uas (alpha Centauri, 3 years)

using Made = std::optional<toliman_track_options>; // of a folder that exists

bool uses_same_frames(const toliman_track_options &a, const toliman_track_options &b) {
    const auto frames = [](const toliman_track_options &how) {
        return std::make_tuple(how.frames.rows, how.frames.cols, how.frames.crop_row, how.frames.crop_col,
                               how.frames.bin, how.frames.bit_depth, how.limits.value);
    };
    return frames(a) == frames(b);
}

int32_t pixel_of(const std::string &dtype) {
    return dtype == "u32le" ? TOLIMAN_PIXEL_U32 : TOLIMAN_PIXEL_U16;
}

// Of a new folder: that of the scene's detector, if its frames come as this pixel type.
uint32_t depth_of(int32_t pixel, uint32_t of_scene) {
    return of_scene != 0 && suits(pixel, of_scene) ? of_scene : pixel == TOLIMAN_PIXEL_U32 ? 32 : 12;
}

// The grid of a new folder without --grid and --mission-days.
void use_cadence(SetupOptions &setup, const Estimator &estimator, Progress &progress) {
    constexpr double kLeast = 4; // of the default grid
    const double days = estimator.cadence_days;
    const std::string text =
        formatted("--mission-days %g: the cadence of ", std::max(days, kLeast)) + estimator.scene.path;
    setup.use_days(std::max(days, kLeast));
    days < kLeast ? progress.warn(text + formatted(" is only %.3g days long", days)) : progress.tell(text);
}

// Refuses a pixel type that does not fit the bit depth of the folder's frames: one of the two is likely a mistake.
void check_depth(const FolderOptions &given, const std::string &dtype, const toliman_track_options &made) {
    if (dtype.empty() || given.bit_depth || suits(pixel_of(dtype), made.frames.bit_depth))
        return;
    const bool wide = dtype == "u32le";
    const std::string depth = std::to_string(made.frames.bit_depth);
    throw Failure(kExitUsage, "--dtype " + dtype + ": the frames of " + given.folder + " have " + depth +
                                  " bits: give --dtype " + (wide ? "u16le" : "u32le") + ", or a new folder; if these " +
                                  dtype + " files also have " + depth + " bits, add --bit-depth " + depth);
}

// The place of the image in a larger frame is never guessed.
void check_crop(const FolderOptions &given, const Estimator &estimator, const toliman_track_options &how) {
    const int64_t bin = std::max<int64_t>(1, how.frames.bin), rows = bin * estimator.rows, cols = bin * estimator.cols;
    if (given.crop.empty() && (how.frames.rows > rows || how.frames.cols > cols))
        throw Failure(kExitUsage, "--shape " + given.shape + ": is larger than the " + shape_text(rows, cols) +
                                      " pixels that are used: give the first of these with --crop ROW,COL");
}

// Nobody asked for this trend: its span, 40 times that of the grid, does not refuse frames if the grid does not suit.
void set_wide_trend(toliman_track_options &how, int32_t order) {
    set_trend(how, order);
    how.grid.trend_start = -1 / how.grid.df;
    how.grid.trend_end = 3 / how.grid.df;
}

// Standard deviation, px, of the separation that a fit finds in a sum with this spread.
double sigma_of(const toliman_fit *fit, const toliman_spread &spread) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.spread = &spread;
    double covariance[TOLIMAN_FIT_MAX_PARAMETERS * TOLIMAN_FIT_MAX_PARAMETERS];
    toliman::check(toliman_fit_predict(fit, &prediction, nullptr, 0, nullptr, covariance));
    return std::sqrt(covariance[0]);
}

// Of values from sums that are expected to have this standard deviation: others may be of up to 64 times as many
// frames, or 16 times fewer. An outlier is one for a folder with a reference orbit, too.
void set_limits_of_sums(toliman_track_options &how, double sigma_px) {
    constexpr double kShare = 8, kOutlierPx = 0.25;
    how.estimator.sigma = sigma_px / kShare;
    how.limits.value = std::max(kOutlierPx, 1e4 * how.estimator.sigma);
}

// The options given, with the settings of an existing folder as defaults.
toliman_track_options track_options(FolderOptions &given, const std::string &dtype, const Estimator &estimator,
                                    const Made &made, Progress &progress) {
    auto how = made.value_or(toliman::sized<toliman_track_options>());
    how.folder = given.folder.c_str();
    const int32_t pixel = dtype.empty() ? given.pixel : pixel_of(dtype);
    if (!made && pixel != 0)
        how.frames.bit_depth = depth_of(pixel, estimator.bit_depth);
    if (!made && given.has_stamps)
        how.frames.stamp = TOLIMAN_FRAME_STAMP_START; // as the mission writes them
    if (!made) {
        how.frames.exposure_s = estimator.scene.exposure_s;
        how.grid.time_offset_ns = estimator.time_zero_ns;
    }
    given.setup.set(how, progress);
    if (!made)
        given.setup.compare(estimator.scene, estimator.time_zero_ns, how, given.notes);
    given.reference.use_scene(estimator.scene, made, given.notes);
    given.reference.set(how, made, progress);
    if (!made && how.reduction.sky == nullptr && estimator.moves && !given.setup.has_trend())
        set_wide_trend(how, kTrendOfMovingStars);
    how.frames.bit_depth = given.bit_depth.value_or(how.frames.bit_depth);
    how.frames.bin = given.bin.value_or(how.frames.bin);
    how.ledger.capacity = given.capacity.value_or(how.ledger.capacity);
    if (given.needs_sigma() && given.sums)
        set_limits_of_sums(how, sigma_of(estimator.fit.get(), *given.sums));
    how.limits.value = given.value_limit.value_or(how.limits.value);
    how.estimator.sigma = given.sigma.value_or(how.estimator.sigma);
    set_two(given.crop, "--crop", ',', 0, how.frames.crop_row, how.frames.crop_col);
    set_two(given.shape, "--shape", 'x', 1, how.frames.rows, how.frames.cols);
    how.threads = given.jobs;
    how.ledger.sync = given.sync == "frame"  ? TOLIMAN_TRACK_SYNC_FRAME
                      : given.sync == "none" ? TOLIMAN_TRACK_SYNC_NONE
                                             : 0;
    how.estimator.cae = estimator.network ? estimator.network->cae.get() : nullptr;
    how.estimator.linear = estimator.linear.get();
    how.estimator.fit = estimator.fit.get();
    how.estimator.bank = estimator.bank.get();
    how.estimator.values[0] = '\0'; // those of the estimator
    how.limits.misfit = Realigner::call;
    how.limits.misfit_data = &given.realigner;
    return how;
}

// For a folder whose frames another estimator measured: which frames must be ingested again.
std::string other_estimator(const std::string &folder, Progress &progress) {
    constexpr size_t kMostSessions = 3;
    const std::vector<toliman_track_stream> streams = streams_of(open_tracker(state_to_read(folder), progress));
    std::vector<std::string> sessions;
    int64_t frames = 0;
    for (const toliman_track_stream &stream : streams) {
        frames += stream.frames;
        if (sessions.size() < kMostSessions)
            sessions.push_back("ids " + std::to_string(stream.first_id) + " to " + std::to_string(stream.last_id) +
                               " of session " + stream.session);
    }
    std::string text = "its frames were measured with another scene, calibration or estimator, or other "
                       "--free or --bad-pixels: give the same, or ingest all " +
                       std::to_string(frames) + " frames again into a new folder";
    if (!sessions.empty())
        text += ": " + joined(sessions);
    if (streams.size() > kMostSessions)
        text += " and " + std::to_string(streams.size() - kMostSessions) + " further sessions";
    return text;
}

// What to do if the folder was created with other settings, which the file `field` contains.
std::string remedy_of(const FolderOptions &given, const toliman_track_options &how, const Made &made,
                      const std::string &field, Progress &progress) {
    const std::string fixed = "these cannot be changed: leave out ";
    if (made && !uses_same_frames(*made, how))
        return fixed + "--shape, --crop, --bin, --bit-depth and --value-limit, or give a new folder";
    if (made && (made->frames.stamp != how.frames.stamp || made->frames.exposure_s != how.frames.exposure_s))
        return fixed + "--stamp and --exposure, or give a new folder";
    if (field == given.folder + "/setup.tlms")
        return "`toliman rebuild " + given.folder + given.setup.text() + given.reference.text() +
               "`, or give a new folder";
    return other_estimator(given.folder, progress);
}

// Names the free parameters of a new folder that were not asked for.
void tell_free(const EstimatorOptions &given, const Estimator &estimator, Progress &progress) {
    if (!given.free.empty() || !estimator.fit)
        return;
    constexpr size_t kAlways = 7;
    const auto info = toliman::result<toliman_fit_info>(toliman_fit_get_info, estimator.fit.get());
    std::vector<toliman_sim_parameter> parameters(static_cast<size_t>(info.parameters),
                                                  toliman::sized<toliman_sim_parameter>());
    size_t count = 0;
    toliman::check(toliman_fit_get_parameters(estimator.fit.get(), parameters.data(), parameters.size(), &count));
    std::string names;
    for (size_t i = kAlways; i < count; i++)
        names += std::string(names.empty() ? "" : " ") + parameters[i].name;
    if (!names.empty())
        progress.tell("the scene is calibrated: each frame also fits " + names + " (--free self)");
}

} // namespace

bool FolderOptions::needs_sigma() const {
    return !estimator_options.fit.empty() && !sigma && !made_with(folder);
}

bool FolderOptions::needs_pixel() const {
    return !bit_depth && !made_with(folder);
}

void FolderOptions::check() const {
    estimator_options.check();
    reference.check();
}

toliman::tracker FolderOptions::open(const std::string &dtype, Estimator &estimator, Progress &progress) {
    const Made made = made_with(folder);
    is_new = !made;
    if (made && made->grid.nf == 0)
        setup.check_complete(folder);
    if (!made && !setup.has_grid() && !estimator_options.has_scene())
        throw Failure(kExitUsage, folder + ": is new, without a scene: give --grid F0:DF:NF or --mission-days N");
    estimator = Estimator(estimator_options, progress);
    if (!made && !setup.has_grid())
        use_cadence(setup, estimator, progress);
    if (made && (made->frames.image_rows != estimator.rows || made->frames.image_cols != estimator.cols))
        throw Failure(kExitUsage, folder + ": " + other_estimator(folder, progress));
    if (made)
        check_depth(*this, dtype, *made);
    const toliman_track_options how = track_options(*this, dtype, estimator, made, progress);
    if (!made) {
        check_crop(*this, estimator, how);
        tell_free(estimator_options, estimator, progress);
        if (!estimator.lacks.empty())
            progress.tell(estimator.lacks);
    }
    try {
        return open_tracker(how, progress);
    } catch (const toliman::error &error) {
        if (error.field() == "options->estimator.bank")
            throw Failure(kExitUsage, message_about(estimator_options.weights, error));
        if (error.status() != TOLIMAN_E_MISMATCH && (!made || uses_same_frames(*made, how)))
            throw;
        throw Failure(kExitUsage,
                      std::string(error.what()) + ": " + remedy_of(*this, how, made, error.field(), progress));
    }
}

void FolderOptions::add_to(CLI::App &command) {
    estimator_options.self_by_default = true;
    estimator_options.add_to(command);
    add_option(&command, "--state", folder, "FOLDER")->required()->transform(plain);
    setup.add_to(command);
    reference.add_to(command);
    add_choice(&command, "--sync", sync, {"frame", "group", "none"});
    command.add_option("--jobs", jobs);
    command.add_option("--bit-depth", bit_depth)->check(CLI::Range(1, 32));
    add_option(&command, "--shape", shape, "ROWSxCOLS");
    add_option(&command, "--crop", crop, "ROW,COL");
    command.add_option("--bin", bin)->check(CLI::Range(1, 65536));
    command.add_option("--value-limit", value_limit)->check(CLI::PositiveNumber);
    command.add_option("--sigma", sigma)->check(CLI::PositiveNumber);
    command.add_option("--capacity", capacity)->check(CLI::Range(int64_t{1}, int64_t{1} << 28));
}

} // namespace cli
