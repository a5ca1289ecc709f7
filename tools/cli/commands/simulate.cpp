// toliman psf, toliman simulate: images to files.
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/name.hpp"
#include "common/failure.hpp"
#include "common/output.hpp"
#include "common/stop.hpp"
#include "common/text.hpp"
#include "frames/frame_loop.hpp"
#include "frames/frames_out.hpp"
#include "options/command.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

struct Options {
    std::string scene, out, star = "both", frames, session, dtype;
    int bit_depth = 0; // 0: that of the scene or, if it has none, 12 for u16le and 32 for u32le
    std::optional<uint64_t> seed;
};

void check_star(const Scene &scene) {
    auto places = toliman::sized<toliman_sim_offsets>();
    toliman::check(toliman_sim_get_offsets(scene.sim.get(), &places));
    if (std::isnan(places.b_x_px))
        throw Failure(kExitUsage, "--star B: " + scene.path + " has only star A");
}

void psf(const Options &options, Progress &progress) {
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

CountFormat count_format(const Options &options, const Scene &scene) {
    const bool wide = options.dtype != "u16le";
    const int width = wide ? 32 : 16, of_scene = static_cast<int>(scene.info.bit_depth);
    const int otherwise = of_scene != 0 ? of_scene : wide ? 32 : 12;
    const int bit_depth = options.bit_depth != 0 ? options.bit_depth : otherwise;
    if (bit_depth > width)
        throw Failure(kExitUsage, (options.bit_depth != 0 ? "--bit-depth " : scene.path + ": detector.bit_depth = ") +
                                      std::to_string(bit_depth) + ": must be 1 to " + std::to_string(width) +
                                      " bits for " + options.dtype);
    return {wide, bit_depth};
}

void check_out(const Options &options) {
    if (options.session.empty() && options.out != "-" && !ends_with(options.out, ".npy") &&
        !ends_with(options.out, ".bin") && !ends_with(options.out, ".fits"))
        throw Failure(kExitUsage, "--out " + options.out +
                                      ": must end in .npy or .bin or .fits, be - for .npy on stdout, or with "
                                      "--session be a folder");
}

std::unique_ptr<FrameOutput> output_of(const Options &options, const Simulated &frames) {
    if (!options.session.empty())
        return session_output(options.out, options.session, count_format(options, frames.scene), frames);
    if (ends_with(options.out, ".bin"))
        return count_output(options.out, count_format(options, frames.scene), frames);
    if (ends_with(options.out, ".fits"))
        return cube_output(options.out, frames);
    return image_output(options.out, {frames.count(), frames.rows(), frames.cols()});
}

void simulate(const Options &options, Progress &progress) {
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

std::string session_complaint(const std::string &name) {
    return toliman::is_name(name) ? ""
                                  : name + ": must be 1 to 64 characters of A-Z a-z 0-9 . _ - and not begin with a dot";
}

} // namespace

void add_psf(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "psf");
    auto options = std::make_shared<Options>();
    add_scene(*command, options->scene);
    add_option(command, "--out", options->out, "FILE", "output file, .npy or .fits; - writes .npy to standard output")
        ->required();
    add_choice(command, "--star", options->star, {"A", "B", "both"}, "stars in the image: A, B or both (default)");
    set_action(*command, context, options, psf);
}

void add_simulate(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "simulate");
    auto options = std::make_shared<Options>();
    add_scene(*command, options->scene);
    add_option(command, "--out", options->out, "PATH",
               "output file, .npy, .bin or .fits; with --session a folder; - writes .npy to standard output")
        ->required();
    add_option(command, "--frames", options->frames, "RANGE",
               "frames FIRST to END - 1: FIRST:END, FIRST:, :END or one number; default all of the cadence");
    add_seed(*command, options->seed, "seed of the noise; default: the scene's");
    CLI::Option *session = command->add_option("--session", options->session,
                                               "write the mission's pair of files, with this session name, into --out");
    CLI::Option *dtype = command->add_option("--dtype", options->dtype, "pixel type of the pair: u16le or u32le");
    session->needs(dtype)->check(CLI::Validator(session_complaint, "NAME"));
    dtype->needs(session)->check(CLI::IsMember({"u16le", "u32le"}));
    command
        ->add_option("--bit-depth", options->bit_depth,
                     "bits per pixel of the pair; default: the scene's, otherwise 12 for u16le and 32 for u32le")
        ->needs(session)
        ->check(CLI::Range(1, 32));
    set_action(*command, context, options, simulate);
}

} // namespace cli
