#include "run/pipeline.hpp"

#include <filesystem>
#include <numeric>

#include "base/constants.hpp"
#include "common/content.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

using toliman::check;

double efficiency_error(const Pipeline &pipeline, double efficiency) {
    return efficiency / std::sqrt(2 * static_cast<double>(pipeline.control_frames));
}

void set_scene(const Scene &scene, uint64_t seed, Json &json) {
    const toliman_sim_info &info = scene.info;
    const toliman_sim_bounds bounds = scene.bounds();
    json.set("scene", scene.info.name, "seed", seed, "scene_folder",
             std::filesystem::absolute(folder_of(scene.path)).lexically_normal().string());
    json.set("frames", info.frames, "amplitude_px", info.amplitude_px, "amplitude_uas", info.amplitude_uas,
             "true_period_days", info.period_days, "crb_px", bounds.crb_px, "crb_flux_shift_px",
             bounds.crb_flux_shift_px, "crb_marginal_px", bounds.crb_marginal_px, "crb_projected_px",
             bounds.crb_projected_px);
}

const char *unit_of(const toliman_sim_info &info) {
    return info.unit == TOLIMAN_SIM_UNIT_DN ? "DN" : info.unit == TOLIMAN_SIM_UNIT_ELECTRON ? "electrons" : "photons";
}

// The expected frame's brightest pixel and its noise.
void set_brightest(const Scene &scene, Json &json) {
    const std::vector<double> expected = scene.image(TOLIMAN_SIM_IMAGE_BOTH);
    const auto brightest = std::max_element(expected.begin(), expected.end());
    const std::vector<double> variance = scene.image(TOLIMAN_SIM_IMAGE_VARIANCE);
    json.set("unit", unit_of(scene.info), "peak_counts", *brightest, "peak_sigma",
             std::sqrt(variance[static_cast<size_t>(brightest - expected.begin())]));
}

// Stars and sky on the detector: +x to higher columns, +y to higher rows.
Json geometry(const Scene &scene, double rotation_deg) {
    constexpr double degree = toliman::kPi / 180;
    auto offsets = toliman::sized<toliman_sim_offsets>();
    check(toliman_sim_get_offsets(scene.sim.get(), &offsets));
    const double sine = std::sin(rotation_deg * degree), cosine = std::cos(rotation_deg * degree);
    return Json("aperture_m", scene.info.aperture_m, "pixel_scale_arcsec", scene.info.pixel_scale_arcsec, "a_x_px",
                offsets.a_x_px, "a_y_px", offsets.a_y_px, "b_x_px", offsets.b_x_px, "b_y_px", offsets.b_y_px, "north_x",
                sine, "north_y", cosine, "east_x", -cosine, "east_y", sine);
}

// The result of the run, by the network or by the fit.
void set_result(const Pipeline &pipeline, double first_time, Json &json) {
    const toliman_period_peak &peak = pipeline.result().peak;
    const std::optional<NetworkOutcome> &network = pipeline.network;
    json.set("estimator", network ? "network" : pipeline.bank ? "bank" : "fit");
    json.set("latent_sigma_px", pipeline.fit && !pipeline.bank ? NAN : pipeline.result().sigma_px, "efficiency",
             pipeline.efficiency());
    json.set("efficiency_error", efficiency_error(pipeline, pipeline.efficiency()));
    json.set("cosine", network ? network->training.cosine : NAN, "period_days", peak.period);
    json.set("half_width_period_days", peak.half_width_period, "fwhm_period_days", peak.fwhm_period);
    json.set("period_error_days", peak.period_error, "at_edge", (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
    json.set("fitted_amplitude_px", peak.amplitude, "fitted_amplitude_error_px", peak.amplitude_error);
    json.set("fitted_phase_rad", peak.phase, "fitted_offset_px", peak.offset, "fitted_time_offset_days", first_time);
    json.set("log10_fap", peak.log10_fap, "power_at_fap_1e-3", pipeline.result().power_at_fap_1e_3);
}

void set_reconstructions(const NetworkOutcome &network, Json &json) {
    const Reconstructions &from = network.reconstructions;
    json.set("mmse", from.mmse, "photon_floor", from.photon_floor, "mssim", from.mssim, "decoder",
             Json("cosine", network.decoder_cosine, "gain", network.decoder_gain));
    json.set("residuals",
             Json("frames", from.validation_frames, "mean", from.residual_mean, "rms", std::sqrt(from.residual_square),
                  "correlation", from.residual_product / from.residual_square));
}

Json estimate_json(const Outcome &outcome) {
    const toliman_period_peak &peak = outcome.peak;
    return Json("sigma_px", outcome.sigma_px, "period_days", peak.period, "period_error_days", peak.period_error,
                "log10_fap", peak.log10_fap, "fwhm_period_days", peak.fwhm_period);
}

Json following_json(const Pipeline &pipeline, const FollowOutcome &of) {
    const bool controls = pipeline.options.controls != Controls::none;
    Json json = estimate_json(of.signal);
    json.set("efficiency", of.efficiency, "efficiency_error", efficiency_error(pipeline, of.efficiency),
             "no_signal_log10_fap", if_known(controls, of.no_signal.peak.log10_fap));
    return json;
}

Json fit_json(const Pipeline &pipeline, const FitOutcome &fit) {
    Json json = following_json(pipeline, fit);
    json.set("bound_px", fit.bound_px, "chi_square", fit.chi_square, "iterations", fit.iterations, "lost", fit.lost);
    return json;
}

Json bank_json(const Pipeline &pipeline, const BankOutcome &bank) {
    Json json = following_json(pipeline, bank);
    json.set("networks", bank.info.networks, "dates", bank.info.dates, "places", bank.info.places, "least_cosine",
             bank.least_cosine);
    json.set("least_efficiency", bank.least_efficiency, "mean_efficiency", bank.mean_efficiency);
    return json;
}

// What the network alone has; null if the stars move.
void set_network(const std::optional<NetworkOutcome> &network, Json &json) {
    if (network) {
        set_reconstructions(*network, json);
        json.set("template", estimate_json(network->template_fit));
        return;
    }
    for (const char *key : {"mmse", "photon_floor", "mssim", "decoder", "residuals", "template"})
        json.set(key, JsonTree());
}

void set_references(const Pipeline &pipeline, Json &json) {
    json.set("fit", pipeline.fit ? std::optional(fit_json(pipeline, *pipeline.fit)) : std::nullopt, "bank",
             pipeline.bank ? std::optional(bank_json(pipeline, *pipeline.bank)) : std::nullopt);
    const toliman_period_peak &truth = pipeline.truth.peak;
    std::optional<Json> true_series, no_signal, untrained;
    if (truth.period > 0)
        true_series.emplace("period_days", truth.period, "half_width_period_days", truth.half_width_period,
                            "fwhm_period_days", truth.fwhm_period, "log10_fap", truth.log10_fap);
    if (pipeline.options.controls != Controls::none) {
        no_signal.emplace("log10_fap", pipeline.no_signal().peak.log10_fap, "frames", pipeline.control_frames);
        if (pipeline.network)
            untrained.emplace("log10_fap", pipeline.network->untrained.peak.log10_fap, "sigma_px",
                              pipeline.network->untrained.sigma_px);
    }
    json.set("true_series", true_series, "controls", name_of(pipeline.options.controls), "no_signal", no_signal,
             "untrained", untrained);
}

Json timings_json(const Timings &spent) {
    return Json("setup_s", spent.setup, "simulate_s", spent.simulate, "train_s", spent.train, "encode_s", spent.encode,
                "fit_s", spent.fit, "period_s", spent.period, "controls_s", spent.controls, "total_s", spent.total);
}

std::string run_result(const RunFiles &files) {
    const Scene &scene = files.scene;
    const Pipeline &pipeline = files.pipeline;
    Json json("schema", "toliman-run/2", "version", toliman_version(), "provenance", provenance());
    set_scene(scene, pipeline.options.seed, json);
    set_brightest(scene, json);
    json.set("geometry", geometry(scene, files.rotation_deg));
    set_result(pipeline, files.cadence.times[0], json);
    set_network(pipeline.network, json);
    set_references(pipeline, json);
    json.set("grid", Json("f0", pipeline.grid.f0, "df", pipeline.grid.df, "nf", pipeline.grid.nf), "timings",
             timings_json(pipeline.timings));
    return json.text();
}

// Values of the frames, as far as the run has them.
void add_values(const RunFiles &files, std::vector<Column> &columns) {
    const Pipeline &pipeline = files.pipeline;
    columns.push_back({"true", &files.cadence.displacements});
    if (pipeline.network) {
        columns.push_back({"latent", &pipeline.network->latent.values});
        columns.push_back({"template", &pipeline.network->template_fit.values});
    }
    if (pipeline.bank) {
        columns.push_back({"latent", &pipeline.bank->signal.values});
        columns.push_back({"efficiency", &pipeline.bank->efficiencies});
    }
    if (pipeline.fit)
        columns.push_back({"fit", &pipeline.fit->signal.values});
}

// Powers; that of the latents has the name power.
void add_powers(const Pipeline &pipeline, std::vector<Column> &columns) {
    if (pipeline.network) {
        columns.push_back({"power", &pipeline.network->latent.power});
        columns.push_back({"template", &pipeline.network->template_fit.power});
    }
    if (pipeline.bank)
        columns.push_back({"power", &pipeline.bank->signal.power});
    columns.push_back({"true", &pipeline.truth.power});
    if (pipeline.fit)
        columns.push_back({"fit", &pipeline.fit->signal.power});
}

std::vector<double> numbers_from(size_t first, size_t count) {
    std::vector<double> numbers(count);
    std::iota(numbers.begin(), numbers.end(), static_cast<double>(first));
    return numbers;
}

void write_tables(OutputFolder &folder, const RunFiles &files) {
    const Pipeline &pipeline = files.pipeline;
    const std::vector<double> frames = numbers_from(0, files.cadence.times.size()),
                              frequencies = frequencies_of(pipeline.grid);
    std::vector<Column> values = {{"frame", &frames}, {"t", &files.cadence.times}},
                        powers = {{"frequency", &frequencies}};
    add_values(files, values);
    add_powers(pipeline, powers);
    write_csv(folder.open("series.csv"), kSeriesMark, values);
    write_csv(folder.open("periodogram.csv"), kPeriodogramMark, powers);
    if (!pipeline.network)
        return;
    const std::vector<double> &losses = pipeline.network->losses, steps = numbers_from(1, losses.size());
    write_csv(folder.open("training.csv"), kTrainingMark, {{"step", &steps}, {"loss", &losses}});
}

} // namespace

void open_files(OutputFolder &folder) {
    for (const char *name :
         {"result.json", "series.csv", "periodogram.csv", "training.csv", "weights.tlmw", "weights.tlmb"})
        folder.open(name);
    folder.open("scene.json", Replaces::scenes);
}

std::string write(OutputFolder &folder, const RunFiles &files) {
    const Pipeline &pipeline = files.pipeline;
    write_tables(folder, files);
    folder.open("scene.json").write(files.scene_text);
    if (pipeline.network)
        folder.open("weights.tlmw").write(pipeline.network->weights);
    if (pipeline.bank)
        folder.open("weights.tlmb").write(pipeline.bank->weights);
    std::string result = run_result(files);
    folder.open("result.json").write(result);
    if (!pipeline.network) { // of a previous run
        folder.remove("training.csv");
        folder.remove("weights.tlmw");
    }
    if (!pipeline.bank)
        folder.remove("weights.tlmb");
    folder.commit("result.json");
    return result;
}

} // namespace cli
