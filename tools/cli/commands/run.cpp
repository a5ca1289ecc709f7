// toliman run: the whole chain from scene to period, and its result files.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/json.hpp"
#include "common/output.hpp"
#include "common/text.hpp"
#include "experiment/pipeline.hpp"
#include "options/command.hpp"
#include "options/seed.hpp"
#include "scenes/scene_json.hpp"
#include "series/fap.hpp"

namespace cli {

namespace {

struct Options {
    std::string scene, folder;
    uint64_t seed = 0;
    bool seed_given = false, as_json = false;
};

constexpr char kDescription[] = R"(Simulate a scene, train the network, encode fresh frames and find the period.

Examples:
  # the scene of the book chapter; the results go to the folder chapter.run
  toliman run chapter.json
  # another seed and another folder; the result as JSON on standard output
  toliman run mission.json --seed 7 --out mission7 --json

Input: a scene with noise and 5 to 400000 frames of at least 256x256 pixels.

Output: a summary on standard output and a folder with these files. `toliman report` draws figures from them.
  result.json      all results (schema toliman-run/2)
  series.csv       columns frame, t (days), true displacement, latent, template value (px)
  periodogram.csv  frequency in 1/day, power of the latents, power of the template's values
  training.csv     loss after each training step
  scene.json       the scene as it was read
  weights.tlmw     the trained network, for toliman encode

The summary compares the network with four references: the template estimator (least squares on the scene's derivative
image), the untrained network, the network on frames without signal, and the Cramer-Rao bound of one frame. Efficiency
is this bound divided by the scatter of the latents over frames without signal. A peak counts as a period that was
found if its log10 FAP is at most -2.

The row `decoder` compares reconstructed frames with the noisy ones, both scaled to 0..1; its values are means over at
most 110 frames. The first is the mean squared error (mmse in result.json). In parentheses is the error expected from
noise alone (photon_floor). The last is 1 - mssim, where mssim is the structural similarity, 1 for equal frames.

Exit codes are listed in `toliman --help`.)";

void print_warnings(const Pipeline &pipeline, const std::string &folder, Progress &progress) {
    if ((pipeline.latent.peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0)
        progress.warn("the peak is at the edge of the frequency grid; the period may lie beyond");
    if (std::isnan(pipeline.efficiency))
        progress.warn("efficiency is not defined: the Cramer-Rao bound assumes photon noise, which these frames lack");
    if (exists(folder + "/report/report.html"))
        progress.warn(folder + "/report shows the previous run; update it with: toliman report " + folder);
}

Json result_json(const Scene &scene, const Pipeline &pipeline) {
    const toliman_sim_info &info = scene.info;
    const toliman_period_peak &peak = pipeline.latent.peak;
    Json json, of_template, no_signal, untrained, truth, grid, timings, decoder;
    of_template.set("sigma_px", pipeline.estimate.sigma_px).set("period_days", pipeline.estimate.peak.period);
    of_template.set("log10_fap", pipeline.estimate.peak.log10_fap);
    of_template.set("fwhm_period_days", pipeline.estimate.peak.fwhm_period);
    no_signal.set("log10_fap", pipeline.no_signal.peak.log10_fap);
    no_signal.set("frames", static_cast<double>(pipeline.control_frames));
    untrained.set("log10_fap", pipeline.untrained.peak.log10_fap).set("sigma_px", pipeline.untrained.sigma_px);
    const toliman_period_peak &true_peak = pipeline.truth.peak;
    truth.set("period_days", true_peak.period).set("half_width_period_days", true_peak.half_width_period);
    truth.set("log10_fap", true_peak.log10_fap);
    decoder.set("cosine", pipeline.decoder_cosine).set("gain", pipeline.decoder_gain);
    grid.set("f0", pipeline.grid.f0).set("df", pipeline.grid.df).set("nf", static_cast<double>(pipeline.grid.nf));
    const Timings &spent = pipeline.timings;
    timings.set("setup_s", spent.setup).set("simulate_s", spent.simulate).set("train_s", spent.train);
    timings.set("encode_s", spent.encode).set("period_s", spent.period).set("controls_s", spent.controls);
    timings.set("total_s", spent.total);

    json.set("schema", "toliman-run/2").set("version", toliman_version());
    json.set("scene", toliman_sim_get_name(scene.sim.get())).set("seed", pipeline.seed);
    json.set("scene_folder", std::filesystem::absolute(folder_of(scene.path)).lexically_normal().string());
    json.set("frames", static_cast<double>(info.frames)).set("amplitude_px", info.amplitude_px);
    json.set("amplitude_uas", info.amplitude_uas);
    json.set("true_period_days", info.period_days).set("crb_px", info.crb_px);
    json.set("crb_flux_shift_px", info.crb_flux_shift_px)
        .set("crb_marginal_px", info.crb_marginal_px)
        .set("crb_projected_px", info.crb_projected_px);
    json.set("latent_sigma_px", pipeline.latent.sigma_px);
    json.set("efficiency", pipeline.efficiency);
    json.set("efficiency_error", pipeline.efficiency / std::sqrt(2 * static_cast<double>(pipeline.control_frames)));
    json.set("cosine", pipeline.training.cosine).set("period_days", peak.period);
    json.set("half_width_period_days", peak.half_width_period).set("fwhm_period_days", peak.fwhm_period);
    json.set("period_error_days", peak.period_error);
    json.set("at_edge", (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
    json.set("fitted_amplitude_px", peak.amplitude).set("log10_fap", peak.log10_fap);
    json.set("mmse", pipeline.mmse).set("photon_floor", pipeline.photon_floor).set("mssim", pipeline.mssim);
    json.set("power_at_fap_1e-3", pipeline.false_alarm_power);
    json.set("decoder", std::move(decoder)).set("template", std::move(of_template));
    true_peak.period > 0 ? json.set("true_series", std::move(truth)) : json.set("true_series", nullptr);
    json.set("no_signal", std::move(no_signal)).set("untrained", std::move(untrained));
    json.set("grid", std::move(grid)).set("timings", std::move(timings));
    return json;
}

void write_series(OutputFile &out, const Cadence &cadence, const Pipeline &pipeline) {
    out.print("%sframe,t,true,latent,template\n", kSeriesMark);
    for (size_t k = 0; k < cadence.times.size(); k++)
        out.print("%zu,%.17g,%.17g,%.17g,%.17g\n", k, cadence.times[k], cadence.displacements[k], pipeline.latents[k],
                  pipeline.estimates[k]);
}

void write_periodogram(OutputFile &out, const Pipeline &pipeline) {
    out.print("%sfrequency,power,template\n", kPeriodogramMark);
    for (size_t k = 0; k < pipeline.power.size(); k++)
        out.print("%.17g,%.17g,%.17g\n", pipeline.grid.f0 + pipeline.grid.df * static_cast<double>(k),
                  pipeline.power[k], pipeline.estimate_power[k]);
}

void write_training(OutputFile &out, const Pipeline &pipeline) {
    out.print("%sstep,loss\n", kTrainingMark);
    for (size_t k = 0; k < pipeline.losses.size(); k++)
        out.print("%zu,%.17g\n", k + 1, pipeline.losses[k]);
}

// The files of a run, all or none: opened before the computation, so that an unwritable folder fails at once.
class RunFolder {
  public:
    RunFolder(const std::string &path, const Scene &scene)
        : scene_text_(whole_text(scene.path)), folder_(path), result_(folder_.file("result.json")),
          series_(folder_.file("series.csv")), periodogram_(folder_.file("periodogram.csv")),
          training_(folder_.file("training.csv")), scene_(folder_.file("scene.json"), Replaces::scenes),
          weights_(folder_.file("weights.tlmw")) {}

    void write(const Cadence &cadence, const Pipeline &pipeline, const std::string &json) {
        scene_.write(scene_text_.data(), scene_text_.size());
        weights_.write(pipeline.weights.data(), pipeline.weights.size());
        result_.write(json.data(), json.size());
        write_series(series_, cadence, pipeline);
        write_periodogram(periodogram_, pipeline);
        write_training(training_, pipeline);
        for (OutputFile *file : {&scene_, &weights_, &series_, &periodogram_, &training_})
            file->commit();
        result_.commit(); // last: a result.json implies that all other files are complete
        folder_.keep();
    }

  private:
    std::string scene_text_; // read before the computation: the file may change meanwhile
    OutputFolder folder_;
    OutputFile result_, series_, periodogram_, training_, scene_, weights_;
};

void print_summary(const Scene &scene, const Pipeline &pipeline, const std::string &folder) {
    const toliman_sim_info &info = scene.info;
    const toliman_period_peak &peak = pipeline.latent.peak;
    const bool found = peak.log10_fap <= kSignificant;
    std::printf("scene         %s: %lld frames of %lldx%lld, seed %llu\n", toliman_sim_get_name(scene.sim.get()),
                static_cast<long long>(info.frames), static_cast<long long>(info.rows),
                static_cast<long long>(info.cols), static_cast<unsigned long long>(pipeline.seed));
    if (info.amplitude_px != 0)
        std::printf("signal        %.3g px with a period of %g days\n", info.amplitude_px, info.period_days);
    std::printf("%s  %s days, log10 FAP %.1f%s\n", found ? "period found" : "highest peak",
                text_with_error(peak.period, peak.period_error).c_str(), peak.log10_fap,
                found ? "" : ": no significant period");
    std::printf("one frame     sigma %.3g px; Cramer-Rao bound %.3g px; efficiency ", pipeline.latent.sigma_px,
                info.crb_projected_px);
    std::printf(std::isnan(pipeline.efficiency) ? "not defined\n" : "%.3f\n", pipeline.efficiency);
    std::printf("template      sigma %.3g px, period %.*f days, log10 FAP %.1f\n", pipeline.estimate.sigma_px,
                decimals_of(pipeline.estimate.peak.period_error, 0), pipeline.estimate.peak.period,
                pipeline.estimate.peak.log10_fap);
    std::printf("controls      log10 FAP %.1f untrained, %.1f without signal\n", pipeline.untrained.peak.log10_fap,
                pipeline.no_signal.peak.log10_fap);
    std::printf("decoder       mean squared error %.4g (noise alone %.4g), 1 - structural similarity %.2g\n",
                pipeline.mmse, pipeline.photon_floor, 1 - pipeline.mssim);
    const Timings &spent = pipeline.timings;
    std::printf("seconds       %.1f: set-up %.1f, train %.1f, simulate %.1f, encode %.1f, period %.1f, controls %.1f\n",
                spent.total, spent.setup, spent.train, spent.simulate, spent.encode, spent.period, spent.controls);
    std::printf("results       %s/result.json, series.csv, periodogram.csv, ...; figures: toliman report %s\n",
                folder.c_str(), folder.c_str());
    print_stdout("");
}

void run(const Options &options, Progress &progress) {
    const auto start = std::chrono::steady_clock::now();
    const Scene scene(options.scene, progress);
    check_cadence(scene, "run");
    const Cadence cadence(scene);
    const std::string name = toliman_sim_get_name(scene.sim.get());
    const std::string path = options.folder.empty() ? (name.empty() ? "scene" : name) + ".run" : options.folder;
    RunFolder folder(path, scene);
    const double setup = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const Pipeline pipeline =
        run_pipeline(scene, cadence, options.seed_given ? options.seed : scene.info.seed, setup, progress);
    const std::string json = result_json(scene, pipeline).text();
    folder.write(cadence, pipeline, json);
    progress.clear();
    print_warnings(pipeline, path, progress);
    if (options.as_json)
        print_stdout(json);
    else
        print_summary(scene, pipeline, path);
}

} // namespace

void add_run(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("run", kDescription);
    auto options = std::make_shared<Options>();
    add_scene(*command, options->scene);
    add_option(command, "--out", options->folder, "FOLDER",
               "folder for the results; default NAME.run, where NAME is the name of the scene, or scene.run if "
               "it has none");
    CLI::Option *seed =
        add_seed(*command, options->seed, "seed of the noise and the initial weights; default: the scene's");
    command->add_flag("--json", options->as_json, "print result.json instead of the summary");
    set_action(*command, context, options, run, [options, seed] { options->seed_given = seed->count() > 0; });
}

} // namespace cli
