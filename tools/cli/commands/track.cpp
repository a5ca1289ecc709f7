// toliman track: frames from the spacecraft, in any order, to the period.
#include <poll.h>

#include <filesystem>

#include "downlink/downlink.hpp"
#include "downlink/folder_options.hpp"
#include "downlink/tracking.hpp"
#include "frames/frames_in.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

struct TrackOptions {
    FolderOptions folder;
    InputOptions input;
    std::string frames, leap_seconds, on_target;
    size_t every = 1;
    bool strict = false;
};

// "A:B", whole numbers.
FrameIds frame_ids(const std::string &text) {
    FrameIds ids;
    if (!text.empty() && (!two_numbers(text, ':', ids.first, ids.end) || ids.first >= ids.end))
        throw Failure(kExitUsage, "--frames " + text + ": must be A:B, two frame ids with A < B");
    return ids;
}

// The files of a state folder must not be among the frames.
void check_folder(const std::string &folder, const std::vector<std::string> &inputs) {
    for (const std::string &input : inputs) {
        std::error_code unknown; // of a folder that does not exist yet
        if (input != "-" && std::filesystem::equivalent(folder, input, unknown))
            throw Failure(kExitUsage, "--state " + folder + ": is an input: name a folder for the results");
    }
}

// A new folder takes the bit depth of its first pair and the noise of its sums: with --follow, waits for the first
// line.
void examine_inputs(TrackOptions &options, Progress &progress) {
    const bool needs_pixel = options.input.dtype.empty() && options.folder.needs_pixel();
    const bool is_stdin = options.input.inputs.front() == "-";
    options.input.suits_folder = options.input.dtype.empty() && !options.folder.bit_depth;
    options.input.needs_dtype = needs_pixel && is_stdin;
    if ((!options.folder.needs_sigma() && !needs_pixel) || is_stdin)
        return;
    KnownSums sums(options.input.inputs);
    if (options.input.follow && sums.waits)
        progress.tell("waiting for the first frame");
    for (; options.input.follow && sums.waits; sums = KnownSums(options.input.inputs)) {
        ::poll(nullptr, 0, 1000); // a signal ends it
        stop_if_asked();
    }
    if (options.folder.needs_sigma())
        options.folder.sums = sums.largest;
    if (needs_pixel)
        options.folder.pixel = first_pixel(options.input);
}

void track(TrackOptions &options, Progress &progress) {
    InputOptions &input = options.input;
    options.folder.check();
    check_inputs(input);
    check_folder(options.folder.folder, input.inputs);
    input.frames = frame_ids(options.frames);
    input.dated.leap_seconds = LeapSeconds(options.leap_seconds);
    options.folder.reference.set_leap_seconds(options.leap_seconds);
    options.folder.setup.set_leap_seconds(options.leap_seconds);
    std::optional<OnTarget> on_target;
    if (!options.on_target.empty())
        on_target.emplace(options.on_target, input.dated.leap_seconds);
    options.folder.has_stamps = has_stamps(input.inputs);
    examine_inputs(options, progress);
    const std::string &folder = options.folder.folder, unused = exists(folder) ? "" : folder;
    Estimator estimator;
    const size_t jobs = options.folder.jobs == 0 ? 64 : options.folder.jobs;
    toliman::tracker tracker = options.folder.open(input.dtype, estimator, progress);
    for (const std::string &note : options.folder.notes)
        progress.tell(note);
    if (const std::string orbit = options.folder.reference.orbit(); !orbit.empty())
        progress.tell(orbit);
    const std::optional<std::string> renewal = estimator.bank ? std::make_optional(estimator.renewal) : std::nullopt;
    const SceneDefaults &scene = estimator.scene;
    input.dated.begins_at_epoch = estimator.time_zero_ns != 0;
    if (!on_target && !scene.on_target_file.empty())
        on_target.emplace(scene.on_target_file, input.dated.leap_seconds);
    Tracking tracking(std::move(tracker),
                      {options.every, jobs, unused, renewal, options.folder.reference.coverage(), scene.exposure_s,
                       scene.on_target_s},
                      options.folder.realigner, progress);
    const bool by_scene = options.folder.is_new && !options.folder.setup.has_exposure() && scene.on_target_s.empty() &&
                          scene.on_target_file.empty();
    try {
        if (on_target)
            tracking.set_on_target(std::move(*on_target), by_scene ? scene.path : "");
        Downlink(input, tracking).read();
    } catch (...) {
        tracking.rescue();
        throw;
    }
    tracking.end();
    if (options.strict && tracking.damaged() > 0)
        throw Failure(
            kExitRejected,
            folder + ": " + std::to_string(tracking.damaged()) +
                " frames or inputs were damaged or quarantined, as listed in the output; the others were processed");
}

} // namespace

void add_track(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "track");
    auto options = std::make_shared<TrackOptions>();
    InputOptions &input = options->input;
    options->folder.add_to(*command);
    command->add_option("--every", options->every)->check(CLI::Range(1u, 1000000000u));
    add_option(command, "--frames", options->frames, "RANGE");
    add_option(command, "--session", input.dated.session, "NAME");
    add_option(command, "--leap-seconds", options->leap_seconds, "FILE");
    add_option(command, "--on-target", options->on_target, "FILE");
    command->add_flag("--strict", options->strict);
    input.add_to(*command);
    set_action(*command, context, options, track);
}

} // namespace cli
