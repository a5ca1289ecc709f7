// toliman run: the whole chain from scene to period, and its result files.
#include <chrono>
#include <filesystem>

#include "frames/frame_loop.hpp"
#include "options/command.hpp"
#include "run/pipeline.hpp"
#include "scenes/scene_json.hpp"
#include "series/fap.hpp"

namespace cli {

namespace {

struct RunCommandOptions {
    std::string scene, folder, bad_pixels;
    uint64_t seed = 0;
    Controls controls = Controls::full;
    bool seed_given = false, as_json = false;
};

void print_warnings(const Pipeline &pipeline, const std::string &folder, Progress &progress) {
    if ((pipeline.result().peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0)
        progress.warn("the peak is at the edge of the frequency grid; the period may lie beyond");
    if (!pipeline.photon_noise)
        progress.warn("efficiency is not defined: the Cramer-Rao bound assumes photon noise, which these frames lack");
    if (pipeline.fit && pipeline.fit->lost != 0)
        progress.warn(formatted("the fit did not converge for %zu of %zu frames: its series lacks them",
                                pipeline.fit->lost, pipeline.fit->signal.values.size()));
    if (exists(folder + "/report/report.html"))
        progress.warn(folder + "/report shows the previous run; update it with: toliman report " + folder);
}

std::string efficiency_text(double efficiency) {
    return std::isnan(efficiency) ? "not defined" : formatted("%.3f", efficiency);
}

// "sigma 1.2e-06 px" and a separator; "" without controls.
std::string sigma_text(const Outcome &outcome, const char *separator) {
    return std::isnan(outcome.sigma_px) ? "" : formatted("sigma %.3g px%s", outcome.sigma_px, separator);
}

void print_period(const Outcome &outcome) {
    const toliman_period_peak &peak = outcome.peak;
    const bool found = peak.log10_fap <= kSignificant;
    std::printf("%s  %s days, log10 FAP %.1f%s\n", found ? "period found" : "highest peak",
                text_with_error(peak.period, peak.period_error).c_str(), peak.log10_fap,
                found ? "" : ": no significant period");
}

void print_network(const NetworkOutcome &network, const Scene &scene) {
    const Outcome &reference = network.template_fit;
    std::printf("one frame     %sCramer-Rao bound %.3g px; efficiency %s\n", sigma_text(network.latent, "; ").c_str(),
                scene.bounds().crb_projected_px, efficiency_text(network.efficiency).c_str());
    std::printf("template      %speriod %.*f days, log10 FAP %.1f\n", sigma_text(reference, ", ").c_str(),
                decimals_of(reference.peak.period_error), reference.peak.period, reference.peak.log10_fap);
}

void print_following(const Pipeline &pipeline) {
    const FitOutcome &fit = *pipeline.fit;
    std::printf("one frame     %sCramer-Rao bound %.3g px; efficiency %s\n",
                sigma_text(pipeline.result(), "; ").c_str(), fit.bound_px,
                efficiency_text(pipeline.efficiency()).c_str());
    if (pipeline.bank) {
        std::printf("bank          %lld networks for %lld dates; efficiency at least %.3f\n",
                    static_cast<long long>(pipeline.bank->info.networks),
                    static_cast<long long>(pipeline.bank->info.dates), pipeline.bank->least_efficiency);
        std::printf("fit           %sefficiency %s, log10 FAP %.1f\n", sigma_text(fit.signal, "; ").c_str(),
                    efficiency_text(fit.efficiency).c_str(), fit.signal.peak.log10_fap);
    }
    std::printf("%s  chi-square %.4f, %.1f steps per frame, %zu frames lost\n",
                pipeline.bank ? "            " : "fit         ", fit.chi_square, fit.iterations, fit.lost);
}

void print_controls(const Pipeline &pipeline) {
    if (pipeline.options.controls == Controls::none) {
        std::printf("controls      none: no frames without signal%s\n",
                    pipeline.network ? ", no untrained network" : "");
        return;
    }
    std::printf("controls      log10 FAP ");
    if (pipeline.network)
        std::printf("%.1f untrained, ", pipeline.network->untrained.peak.log10_fap);
    std::printf("%.1f without signal%s\n", pipeline.no_signal().peak.log10_fap,
                pipeline.options.controls == Controls::quick ? "; 200 frames without signal" : "");
}

void print_decoder(const Reconstructions &reconstructions) {
    std::printf("decoder       mean squared error %.4g (noise alone %.4g), 1 - structural similarity %.2g\n",
                reconstructions.mmse, reconstructions.photon_floor, 1 - reconstructions.mssim);
}

void print_seconds(const Pipeline &pipeline) {
    const Timings &spent = pipeline.timings;
    std::printf("seconds       %.1f: set-up %.1f, ", spent.total, spent.setup);
    if (pipeline.network)
        std::printf("train %.1f, simulate %.1f, encode %.1f, ", spent.train, spent.simulate, spent.encode);
    else if (pipeline.bank)
        std::printf("train %.1f, simulate %.1f, fit and encode %.1f, ", spent.train, spent.simulate, spent.fit);
    else
        std::printf("simulate %.1f, fit %.1f, ", spent.simulate, spent.fit);
    std::printf("period %.1f, controls %.1f\n", spent.period, spent.controls);
}

void print_summary(const Scene &scene, const Pipeline &pipeline, const std::string &folder) {
    const toliman_sim_info &info = scene.info;
    std::printf("scene         %s: %lld frames of %lldx%lld, seed %llu\n", scene.info.name,
                static_cast<long long>(info.frames), static_cast<long long>(info.rows),
                static_cast<long long>(info.cols), static_cast<unsigned long long>(pipeline.options.seed));
    if (info.amplitude_px != 0)
        std::printf("signal        %.3g px with a period of %g days\n", info.amplitude_px, info.period_days);
    print_period(pipeline.result());
    if (pipeline.network)
        print_network(*pipeline.network, scene);
    else
        print_following(pipeline);
    print_controls(pipeline);
    if (pipeline.network)
        print_decoder(pipeline.network->reconstructions);
    print_seconds(pipeline);
    std::printf("results       %s/result.json, series.csv, periodogram.csv, ...; figures: toliman report %s\n",
                folder.c_str(), folder.c_str());
    print_stdout("");
}

void run(const RunCommandOptions &options, Progress &progress) {
    const auto start = std::chrono::steady_clock::now();
    const Scene scene(options.scene, progress, options.bad_pixels);
    check_cadence(scene, "run");
    const Cadence cadence(scene);
    const std::string name = scene.info.name;
    const std::string path = options.folder.empty() ? (name.empty() ? "scene" : name) + ".run" : options.folder;
    const std::string text = whole_text(scene.path); // before the computation: the file may change meanwhile
    const JsonTree tree = parse_scene(scene.path, text);
    const cJSON *rotation = item_of(item_of(tree.get(), "detector"), "rotation_deg");
    OutputFolder folder(path);
    open_files(folder);
    const RunOptions chosen = {options.seed_given ? options.seed : scene.info.seed, options.controls};
    const double setup = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const Pipeline pipeline = run_pipeline(scene, cadence, chosen, setup, progress);
    const double degrees = rotation != nullptr ? rotation->valuedouble : 0;
    const std::string json = write(folder, {scene, text, degrees, cadence, pipeline});
    progress.clear();
    print_warnings(pipeline, path, progress);
    if (options.as_json)
        print_stdout(json);
    else
        print_summary(scene, pipeline, path);
}

} // namespace

void add_run(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "run");
    auto options = std::make_shared<RunCommandOptions>();
    add_scene(*command, options->scene);
    add_bad_pixels(*command, options->bad_pixels);
    add_option(command, "--out", options->folder, "FOLDER");
    CLI::Option *seed = add_seed(*command, options->seed);
    add_controls(*command, options->controls);
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, run, [options, seed] { options->seed_given = seed->count() > 0; });
}

} // namespace cli
