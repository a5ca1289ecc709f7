// toliman coadd: short frames to sums.
#include <filesystem>

#include "downlink/adding.hpp"
#include "downlink/downlink.hpp"
#include "frames/scene_fit.hpp"
#include "options/command.hpp"
#include "options/duration.hpp"

namespace cli {

namespace {

struct CoaddOptions {
    InputOptions input;
    std::string scene, every, gap, shift, bad_pixels, out, session = "sums", leap_seconds;
    double motion = 0, chi = 0, exposure = 0, days = 0;
    unsigned range = 0, jobs = 0;
    bool strict = false;
};

toliman_fit_prediction prediction_of(const CoaddOptions &options) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.time_days = options.days;
    const size_t colon = options.shift.find(':');
    if (!options.shift.empty() &&
        (colon == std::string::npos || !number_of(options.shift.substr(0, colon), prediction.x_px) ||
         !number_of(options.shift.substr(colon + 1), prediction.y_px)))
        throw Failure(kExitUsage, "--shift " + options.shift + ": must be X:Y, px");
    return prediction;
}

toliman::frame_adder adder_of(const CoaddOptions &options, const toliman_fit *fit, double every, double gap,
                              Progress &progress) {
    auto given = toliman::sized<toliman_coadd_options>();
    given.flags = every > 0 ? TOLIMAN_COADD_ALIGNED : 0;
    given.threads = options.jobs;
    given.range_px = options.range;
    given.chi_square_max = options.chi;
    given.duration_s = every;
    given.gap_s = gap;
    given.motion_px = options.motion;
    given.progress = Progress::callback;
    given.progress_data = &progress;
    const toliman_fit_prediction prediction = prediction_of(options);
    const StopLimit limit;
    toliman_coadd *made = nullptr;
    const toliman_status status = toliman_coadd_create(fit, &prediction, &given, &made);
    if (status != TOLIMAN_OK) {
        const toliman::error error(status);
        refuse_option(error, {{"range_px", "--range"},
                              {"chi_square_max", "--chi-limit"},
                              {"duration_s", "--every"},
                              {"gap_s", "--gap"},
                              {"motion_px", "--motion"},
                              {"prediction", "--shift"}});
        throw error;
    }
    return toliman::frame_adder(made);
}

void coadd(CoaddOptions &options, Progress &progress) {
    const double every = seconds_of("--every", options.every), gap = seconds_of("--gap", options.gap);
    check_inputs(options.input);
    options.input.dated.leap_seconds = LeapSeconds(options.leap_seconds);
    const SceneFit scene = fit_of_scene(options.scene, "none", options.bad_pixels, progress);
    auto settings = toliman::sized<toliman_track_options>();
    settings.frames.stamp = TOLIMAN_FRAME_STAMP_START;
    settings.frames.exposure_s = options.exposure > 0 ? options.exposure : scene.scene.info.exposure_s;
    settings.frames.rows = scene.scene.info.rows;
    settings.frames.cols = scene.scene.info.cols;
    toliman::frame_adder adder = adder_of(options, scene.fit.get(), every, gap, progress);
    const auto info = toliman::result<toliman_coadd_info>(toliman_coadd_get_info, adder.get());
    std::error_code error;
    std::filesystem::create_directory(options.out, error);
    if (!is_folder(options.out))
        throw Failure(kExitOutput, options.out + ": must be a folder");
    SumFiles files(options.out, options.session,
                   formatted("--every %.17g --gap %.17g --motion %.17g --exposure %.17g --range %u --chi-limit %.17g "
                             "--days %.17g",
                             every, gap, options.motion, settings.frames.exposure_s, options.range, options.chi,
                             options.days) +
                       (options.shift.empty() ? "" : " --shift " + options.shift) +
                       (options.input.roi.empty() ? "" : " --roi " + options.input.roi),
                   info.digest);
    if (files.resumes())
        progress.tell(
            formatted("%s: continues after %lld sums", options.out.c_str(), static_cast<long long>(files.sums())));
    Adding adding(std::move(adder), files, settings, progress);
    try {
        Downlink(options.input, adding).read();
    } catch (...) {
        adding.save();
        throw;
    }
    adding.finish();
    adding.end();
    if (options.strict && adding.damaged() > 0)
        throw Failure(kExitRejected, options.out + ": " + std::to_string(adding.damaged()) +
                                         " frames or inputs were left out; the others were added");
}

} // namespace

void add_coadd(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "coadd");
    auto options = std::make_shared<CoaddOptions>();
    InputOptions &input = options->input;
    add_option(command, "--fit", options->scene, "SCENE")->required();
    add_option(command, "--out", options->out, "FOLDER")->required();
    add_option(command, "--session", options->session, "NAME")->check(CLI::Validator(session_complaint, "NAME"));
    add_option(command, "--every", options->every, "TIME");
    add_option(command, "--gap", options->gap, "TIME");
    command->add_option("--motion", options->motion)->check(CLI::Range(1e-6, 16.0));
    command->add_option("--range", options->range)->check(CLI::Range(1u, 14u));
    add_option(command, "--shift", options->shift, "X:Y");
    command->add_option("--days", options->days);
    command->add_option("--chi-limit", options->chi)->check(CLI::Range(1.0001, 1e6));
    command->add_option("--exposure", options->exposure)->check(CLI::PositiveNumber);
    add_bad_pixels(*command, options->bad_pixels);
    add_option(command, "--leap-seconds", options->leap_seconds, "FILE");
    command->add_option("--jobs", options->jobs);
    command->add_flag("--strict", options->strict);
    input.add_to(*command);
    set_action(*command, context, options, coadd);
}

} // namespace cli
