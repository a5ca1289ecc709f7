// toliman psf, toliman simulate: images and frames to files.

#include "frames/frame_loop.hpp"
#include "frames/frames_out.hpp"
#include "frames/stream_frames.hpp"
#include "options/command.hpp"
#include "options/duration.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

struct SimulateOptions {
    std::string scene, out, star = "both", frames, session, dtype;
    int bit_depth = 0; // 0: that of the scene or, if it has none, 12 for u16le and 32 for u32le
    std::optional<uint64_t> seed;
    StreamOptions stream;
    std::string duration, jitter, drift, drops, restarts, sessions, format = "pair", roi = kOnlyRegion;
};

void check_star(const Scene &scene) {
    auto places = toliman::sized<toliman_sim_offsets>();
    toliman::check(toliman_sim_get_offsets(scene.sim.get(), &places));
    if (std::isnan(places.b_x_px))
        throw Failure(kExitUsage, "--star B: " + scene.path + " has only star A");
}

void psf(const SimulateOptions &options, Progress &progress) {
    if (options.out != "-" && !ends_with(options.out, ".npy") && !ends_with(options.out, ".fits"))
        throw Failure(kExitUsage, "--out " + options.out + ": must end in .npy or .fits, or be - for .npy on stdout");
    const Scene scene(options.scene, progress);
    check_not_input(options.out, {scene.path});
    if (options.star == "B")
        check_star(scene);
    const int32_t kind = options.star == "A"   ? TOLIMAN_SIM_IMAGE_STAR_A
                         : options.star == "B" ? TOLIMAN_SIM_IMAGE_STAR_B
                                               : TOLIMAN_SIM_IMAGE_BOTH;
    const std::vector<double> image = scene.image(kind);
    const auto cols = static_cast<size_t>(scene.info.cols);
    const auto out = image_output(options.out, {image.size() / cols, cols}, &scene);
    out->write(image.data(), 1);
    out->commit();
}

// u16le by default if the scene has at most 16 bits; a file without header is u32le.
bool is_wide(const SimulateOptions &options, int bits_of_scene) {
    if (!options.dtype.empty() || options.session.empty())
        return options.dtype != "u16le";
    const int bits = options.bit_depth != 0 ? options.bit_depth : bits_of_scene;
    return bits == 0 || bits > 16;
}

CountFormat count_format(const SimulateOptions &options, const Scene &scene) {
    const int of_scene = static_cast<int>(scene.info.bit_depth);
    const bool wide = is_wide(options, of_scene);
    const int width = wide ? 32 : 16, otherwise = of_scene != 0 ? of_scene : wide ? 32 : 12;
    const CountFormat format = {wide, options.bit_depth != 0 ? options.bit_depth : otherwise};
    if (format.bit_depth > width)
        throw Failure(kExitUsage, (options.bit_depth != 0 ? "--bit-depth " : scene.path + ": detector.bit_depth = ") +
                                      std::to_string(format.bit_depth) + ": must be 1 to " + std::to_string(width) +
                                      " bits for " + format.dtype());
    return format;
}

void check_out(const SimulateOptions &options) {
    if (options.session.empty() && options.out != "-" && !ends_with(options.out, ".npy") &&
        !ends_with(options.out, ".bin") && !ends_with(options.out, ".fits"))
        throw Failure(kExitUsage, "--out " + options.out +
                                      ": must end in .npy or .bin or .fits, be - for .npy on stdout, or with "
                                      "--session be a folder");
}

std::unique_ptr<FrameOutput> output_of(const SimulateOptions &options, const Simulated &frames) {
    if (!options.session.empty())
        return session_output(options.out, options.session, count_format(options, frames.scene), frames);
    if (ends_with(options.out, ".bin"))
        return count_output(options.out, count_format(options, frames.scene), frames);
    if (ends_with(options.out, ".fits"))
        return cube_output(options.out, frames);
    return image_output(options.out, {frames.count(), frames.rows(), frames.cols()});
}

// "A:B" or "A", whose parts are numbers; B is then unchanged.
void set_pair(const char *option, const std::string &text, const char *form, double &a, double &b) {
    const size_t colon = text.find(':');
    const bool has_second = colon != std::string::npos;
    if (!text.empty() &&
        !(number_of(text.substr(0, colon), a) && (!has_second || number_of(text.substr(colon + 1), b))))
        throw Failure(kExitUsage, std::string(option) + " " + text + ": must be " + form);
}

StreamOptions stream_of(const SimulateOptions &options) {
    StreamOptions stream = options.stream;
    const auto require = [](bool is_right, const char *option, const std::string &text, const char *rule) {
        if (!is_right)
            throw Failure(kExitUsage, std::string(option) + " " + text + ": " + rule);
    };
    stream.duration_s = seconds_of("--duration", options.duration);
    stream.restart_s = seconds_of("--restarts", options.restarts);
    stream.session_s = seconds_of("--sessions", options.sessions);
    const auto is_long = [](double time_s) { return time_s == 0 || time_s >= 3; };
    require(is_long(stream.restart_s), "--restarts", options.restarts, "must be at least 3 s");
    require(is_long(stream.session_s), "--sessions", options.sessions, "must be at least 3 s");
    require(stream.restart_s == 0 || stream.session_s == 0 || stream.restart_s < stream.session_s, "--restarts",
            options.restarts, "must be shorter than --sessions: restarts count from the start of a session");
    require((stream.restart_s == 0 && stream.session_s == 0) || stream.rate_hz >= 1,
            "--restarts, --sessions:", "the rate", "must be at least 1 Hz, as the pause after them is 1 s");
    require(stream.duration_s * stream.rate_hz < 0x1p40, "--duration", options.duration, "is too long");
    set_pair("--jitter", options.jitter, "RMS or RMS:HZ", stream.jitter_px, stream.corner_hz);
    require(stream.jitter_px >= 0 && stream.corner_hz > 0, "--jitter", options.jitter, "must be positive numbers");
    const size_t colon = options.drift.find(':');
    set_pair("--drift", options.drift.substr(0, colon), "PX or PX:TIME", stream.drift_px, stream.drift_s);
    require(colon != 0, "--drift", options.drift, "must be PX or PX:TIME");
    if (colon != std::string::npos)
        stream.drift_s = seconds_of("--drift", options.drift.substr(colon + 1));
    require(stream.drift_px >= 0 && stream.drift_s > 0, "--drift", options.drift, "must be positive numbers");
    require(6 * stream.jitter_px + stream.drift_px <= kFarthestPx, "--drift, --jitter:", "the stars",
            "must move by at most 14 px, the drift and 6 times the jitter");
    set_pair("--drops", options.drops, "FRACTION or FRACTION:RUN", stream.drops, stream.drop_run);
    require(stream.drops >= 0 && stream.drops <= 0.5 && stream.drop_run >= 1 && stream.drop_run <= 1e9, "--drops",
            options.drops, "must be a fraction up to 0.5 and a mean length of at least 1 frame");
    return stream;
}

void simulate_stream(const SimulateOptions &options, Progress &progress) {
    const StreamOptions how = stream_of(options);
    refuse_mistakes(
        {{options.session.empty(), "--rate: --session NAME is required"},
         {options.bit_depth != 0, "--bit-depth: with --rate, set detector.bit_depth of the scene"},
         {options.dtype == "u32le", "--dtype u32le: the frames of a stream are u16le"},
         {options.format != "pair" && options.roi != kOnlyRegion, "--roi: only pairs of files name the region"}});
    const SceneFit scene = fit_of_scene(options.scene, "none", "", progress);
    const toliman_sim_info &info = scene.scene.info;
    check_stream_scene(scene.scene, how.rate_hz);
    const uint64_t seed = options.seed.value_or(info.seed);
    Stream stream(how, seed, info.time_zero_ns);
    const FrameRange range(options.frames, stream.count());
    OutputFolder folder(options.out);
    const StreamLayout layout = {folder,
                                 options.session,
                                 options.roi,
                                 static_cast<size_t>(info.rows),
                                 static_cast<size_t>(info.cols),
                                 info.exposure_s,
                                 static_cast<int>(info.bit_depth)};
    const auto output = options.format == "netcdf" ? batch_stream(layout)
                        : options.format == "fits" ? fits_stream(layout)
                                                   : pair_stream(layout);
    TruthTable truth(layout);
    if (options.format == "pair")
        truth.need_space({static_cast<size_t>(range.end - range.first), layout.pixels()}, sizeof(uint16_t));
    draw_stream(scene, stream, seed, range, *output, truth, progress);
    output->commit();
    truth.commit();
    folder.keep();
}

void simulate(const SimulateOptions &options, Progress &progress) {
    if (options.stream.rate_hz > 0)
        return simulate_stream(options, progress);
    check_out(options);
    const Scene scene(options.scene, progress);
    check_not_input(options.out, {scene.path});
    const Simulated frames = {scene, FrameRange(options.frames, scene.info.frames),
                              options.seed.value_or(scene.info.seed)};
    const size_t total = frames.count();
    const auto out = output_of(options, frames);
    const auto write = [&](size_t at, size_t count, const double *images) {
        out->write(images, count);
        progress.show("simulate", static_cast<double>(at + count) / static_cast<double>(total));
    };
    {
        const StopLimit limit;
        for_frames(scene, frames.seed, frames.range.first, total, nullptr, write);
    }
    out->commit();
}

void add_stream(CLI::App &command, SimulateOptions &options) {
    CLI::Option *rate = command.add_option("--rate", options.stream.rate_hz);
    CLI::Option *duration = add_option(&command, "--duration", options.duration, "TIME");
    rate->check(CLI::Range(1e-3, 1e4))->needs(duration);
    duration->needs(rate);
    const auto add = [&](const char *name, std::string &value, const char *type) {
        return add_option(&command, name, value, type)->needs(rate);
    };
    add("--format", options.format, "FORMAT")->check(CLI::IsMember({"pair", "netcdf", "fits"}));
    add("--roi", options.roi, "LABEL")->check(CLI::Validator(session_complaint, "LABEL"));
    add("--jitter", options.jitter, "RMS[:HZ]");
    add("--drift", options.drift, "PX[:TIME]");
    command.add_option("--cosmic-rays", options.stream.hits)->needs(rate)->check(CLI::Range(0.0, 100.0));
    add("--drops", options.drops, "FRACTION[:RUN]");
    add("--restarts", options.restarts, "TIME");
    add("--sessions", options.sessions, "TIME");
}

} // namespace

void add_psf(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "psf");
    auto options = std::make_shared<SimulateOptions>();
    add_scene(*command, options->scene);
    add_option(command, "--out", options->out, "FILE")->required();
    add_choice(command, "--star", options->star, {"A", "B", "both"});
    set_action(*command, context, options, psf);
}

void add_simulate(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "simulate");
    auto options = std::make_shared<SimulateOptions>();
    add_scene(*command, options->scene);
    add_option(command, "--out", options->out, "PATH")->required();
    add_option(command, "--frames", options->frames, "RANGE");
    add_seed(*command, options->seed);
    CLI::Option *session = command->add_option("--session", options->session);
    CLI::Option *dtype = command->add_option("--dtype", options->dtype);
    session->check(CLI::Validator(session_complaint, "NAME"));
    dtype->needs(session)->check(CLI::IsMember({"u16le", "u32le"}));
    command->add_option("--bit-depth", options->bit_depth)->needs(session)->check(CLI::Range(1, 32));
    add_stream(*command, *options);
    set_action(*command, context, options, simulate);
}

} // namespace cli
