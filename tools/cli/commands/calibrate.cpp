// toliman calibrate: the parameters of the telescope from frames.
#include "common/content.hpp"
#include "common/job_journal.hpp"
#include "frames/calibration_output.hpp"
#include "options/command.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

constexpr size_t kAllFrames = 1000000;

struct CalibrateOptions {
    CalibrationRequest request;
    bool chooses = false; // --choose is given
    bool map = false, detector = false, improve = false, as_json = false;
};

// Without --out. A scene that is not the result of a calibration is not replaced.
std::string default_out(Progress &progress) {
    const std::string out = "fitted.json";
    if (identify(out).content == Content::scene && item_of(read_scene_json(out).get(), "calibration") == nullptr)
        const OutputFile probe(out);
    progress.tell("the fitted scene will be " + out + " (--out)");
    return out;
}

void calibrate(CalibrateOptions &options, Progress &progress) {
    CalibrationRequest &request = options.request;
    const toliman_calibration_options &how = request.options;
    refuse_mistakes(
        {{how.map_rms_nm != 0 && !options.map, formatted("--map-rms %g: needs --map", how.map_rms_nm)},
         {how.smoothness != 0 && how.window_days == 0 && !options.improve,
          formatted("--smoothness %g: needs --windows or --improve", how.smoothness)},
         {how.response_rms != 0 && !options.detector,
          formatted("--response-rms %g: needs --detector", how.response_rms)},
         {how.window_days != 0 && options.detector,
          formatted("--windows %g: not with --detector, whose response is one for all frames", how.window_days)}});
    if (options.detector && !options.chooses)
        request.most_frames = kAllFrames;
    if (options.detector)
        request.options.flags |= TOLIMAN_CALIBRATION_DETECTOR;
    if (options.map)
        request.options.flags |= TOLIMAN_CALIBRATION_MAP;
    if (options.improve)
        request.options.flags |= TOLIMAN_CALIBRATION_IMPROVE;
    if (request.out.empty())
        request.out = default_out(progress);
    const CalibrationFiles files(request.out);
    std::vector<std::string> inputs = request.frames.files;
    inputs.push_back(request.scene);
    check_not_input(request.out, inputs);
    CalibrationOutput output(files, options.detector);
    if (!request.resume)
        remove_journal(files.journal());
    Calibration calibration(request, files, progress);
    calibration.run(progress);
    write_and_remove(files.journal(), [&] { output.write(calibration); });
    output.warn(calibration, progress);
    if (options.as_json)
        print_stdout(output.json());
    else
        output.print(calibration);
    stop_if_asked();
}

} // namespace

void add_calibrate(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "calibrate");
    auto options = std::make_shared<CalibrateOptions>();
    CalibrationRequest &request = options->request;
    add_scene(*command, request.scene);
    add_bad_pixels(*command, request.bad_pixels);
    request.frames.add_to(*command);
    add_option(command, "--out", request.out, "FILE");
    CLI::Option *free = add_option(command, "--free", request.free, "NAMES");
    CLI::Option *choose =
        command->add_option("--choose", request.most_frames)->check(CLI::Range(size_t{2}, kAllFrames));
    command->add_flag("--map", options->map);
    command->add_flag("--detector", options->detector);
    command->add_flag("--improve", options->improve);
    command->add_option("--map-rms", request.options.map_rms_nm)->check(CLI::Range(1e-3, 1e4));
    command->add_option("--response-rms", request.options.response_rms)->check(CLI::Range(1e-6, 0.5));
    command->add_option("--windows", request.options.window_days)->check(CLI::Range(1e-6, 1e6));
    command->add_option("--smoothness", request.options.smoothness)->check(CLI::Range(1e-9, 1e3));
    command->add_option("--capture", request.options.capture_px)->check(CLI::Range(0.1, 64.0));
    command->add_option("--iterations", request.options.most_iterations)->check(CLI::Range(1, 1000));
    command->add_option("--threads", request.options.threads)->check(CLI::Range(1u, 1024u));
    command->add_flag("--resume", request.resume);
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, calibrate, [options, free, choose] {
        options->request.by_free = free->count() > 0;
        options->chooses = choose->count() > 0;
    });
}

} // namespace cli
