// toliman psf, toliman simulate: images to files.
#include <cmath>
#include <cstdio>
#include <limits>

#include "command.hpp"
#include "failure.hpp"
#include "npy.hpp"
#include "output.hpp"
#include "scene.hpp"

namespace cli {

namespace {

struct Options {
    std::string scene, out, star = "both", frames;
    uint64_t seed = 0;
    bool seed_given = false;
};

constexpr size_t kFramesAtOnce = 32;

constexpr char kPsfDescription[] = R"(Expected (noise-free) image of a scene as float64 .npy, in photons of a frame.

Example:
  toliman psf examples/scenes/chapter.json --out psf.npy --star A)";

constexpr char kSimulateDescription[] = R"(Noisy frames of a scene.

Examples:
  toliman simulate chapter.json --frames 0:100 --out frames.npy    float64, exact counts (with read noise where asked)
  toliman simulate chapter.json --frames 0:100 --out frames.bin    u32 little-endian, rounded to counts, no header

Frame k depends on the scene, the seed and k alone: any part of the cadence may be made anywhere, in any order.)";

bool ends_with(const std::string &text, const std::string &end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

void psf(const Options &options, Progress &progress) {
    const Scene scene(options.scene, progress);
    std::vector<double> image(scene.pixels());
    const int32_t kind = options.star == "A"   ? TOLIMAN_IMAGE_STAR_A
                         : options.star == "B" ? TOLIMAN_IMAGE_STAR_B
                                               : TOLIMAN_IMAGE_BOTH;
    const auto cols = static_cast<size_t>(scene.info.cols);
    toliman::check(toliman_sim_get_image(scene.sim.get(), kind, image.data(), cols));
    OutputFile out(options.out);
    write_npy_header(out, {image.size() / cols, cols});
    out.write(image.data(), image.size() * sizeof image[0]);
    out.commit();
}

// Rounded to counts; what does not fit 32 bits is an error, never a wrapped number.
void write_u32(OutputFile &out, const std::vector<double> &images, size_t count) {
    std::vector<uint32_t> counts(count);
    for (size_t i = 0; i < count; i++) {
        const double rounded = std::fmax(0.0, std::nearbyint(images[i]));
        if (rounded > std::numeric_limits<uint32_t>::max())
            throw Failure(kExitUsage, "a pixel of " + std::to_string(rounded) +
                                          " counts does not fit u32: write .npy, or ask for fewer photons");
        counts[i] = static_cast<uint32_t>(rounded);
    }
    out.write(counts.data(), count * sizeof counts[0]);
}

void simulate(const Options &options, Progress &progress) {
    const bool npy = options.out == "-" || ends_with(options.out, ".npy");
    if (!npy && !ends_with(options.out, ".bin"))
        throw Failure(kExitUsage, "--out " + options.out + ": must end in .npy or .bin, or be - for .npy on stdout");
    const Scene scene(options.scene, progress);
    const FrameRange range(options.frames, scene.info.frames);
    const auto total = static_cast<size_t>(range.end - range.first);
    OutputFile out(options.out);
    if (npy)
        write_npy_header(out, {total, static_cast<size_t>(scene.info.rows), static_cast<size_t>(scene.info.cols)});
    std::vector<double> images(std::min(total, kFramesAtOnce) * scene.pixels());
    const uint64_t seed = options.seed_given ? options.seed : scene.info.seed;
    for (size_t done = 0; done < total;) {
        const size_t count = std::min(kFramesAtOnce, total - done);
        toliman::check(toliman_sim_frame_many(scene.sim.get(), seed, range.first + static_cast<int64_t>(done), count,
                                              nullptr, 0, images.data()));
        if (npy)
            out.write(images.data(), count * scene.pixels() * sizeof images[0]);
        else
            write_u32(out, images, count * scene.pixels());
        done += count;
        progress.show("simulate", static_cast<double>(done) / static_cast<double>(total));
        stop_if_asked();
    }
    out.commit();
}

} // namespace

void add_psf(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("psf", kPsfDescription);
    auto options = std::make_shared<Options>();
    command->add_option("SCENE", options->scene, "scene file (JSON, schema toliman-scene/1)")->required();
    command->add_option("--out", options->out, "the .npy file to write; - is standard output")->required();
    command->add_option("--star", options->star, "A, B or both (default)")->check(CLI::IsMember({"A", "B", "both"}));
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            psf(*options, progress);
        };
    });
}

void add_simulate(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("simulate", kSimulateDescription);
    auto options = std::make_shared<Options>();
    command->add_option("SCENE", options->scene, "scene file (JSON, schema toliman-scene/1)")->required();
    command->add_option("--out", options->out, "the .npy or .bin file to write; - is .npy on standard output")
        ->required();
    command->add_option("--frames", options->frames, "FIRST:END, default all of the cadence");
    CLI::Option *seed = command->add_option("--seed", options->seed, "noise seed, default the scene's");
    command->callback([&context, options, seed] {
        options->seed_given = seed->count() > 0;
        context.action = [&context, options] {
            Progress progress(context.style());
            simulate(*options, progress);
        };
    });
}

} // namespace cli
