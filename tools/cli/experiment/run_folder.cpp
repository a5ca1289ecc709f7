#include "experiment/run_folder.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "base/constants.hpp"
#include "common/content.hpp"
#include "common/npy.hpp"
#include "common/provenance.hpp"
#include "common/text.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

using toliman::check;

void set_scene(const Scene &scene, uint64_t seed, Json &json) {
    const toliman_sim_info &info = scene.info;
    const toliman_sim_bounds bounds = scene.bounds();
    json.set("scene", toliman_sim_get_name(scene.sim.get()), "seed", seed, "scene_folder",
             std::filesystem::absolute(folder_of(scene.path)).lexically_normal().string());
    json.set("frames", info.frames, "amplitude_px", info.amplitude_px, "amplitude_uas", info.amplitude_uas,
             "true_period_days", info.period_days, "crb_px", bounds.crb_px, "crb_flux_shift_px",
             bounds.crb_flux_shift_px, "crb_marginal_px", bounds.crb_marginal_px, "crb_projected_px",
             bounds.crb_projected_px);
}

// The expected frame's brightest pixel and its noise.
void set_brightest(const Scene &scene, const RunImage &expected, Json &json) {
    const auto brightest = std::max_element(expected.values.begin(), expected.values.end());
    const std::vector<double> variance = scene.image(TOLIMAN_SIM_IMAGE_VARIANCE);
    json.set("unit", unit_of(scene.info), "peak_counts", *brightest, "peak_sigma",
             std::sqrt(variance[static_cast<size_t>(brightest - expected.values.begin())]));
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

void set_latent(const Pipeline &pipeline, double first_time, Json &json) {
    const toliman_period_peak &peak = pipeline.latent.peak;
    json.set("latent_sigma_px", pipeline.latent.sigma_px, "efficiency", pipeline.efficiency);
    json.set("efficiency_error", pipeline.efficiency / std::sqrt(2 * static_cast<double>(pipeline.control_frames)));
    json.set("cosine", pipeline.training.cosine, "period_days", peak.period);
    json.set("half_width_period_days", peak.half_width_period, "fwhm_period_days", peak.fwhm_period);
    json.set("period_error_days", peak.period_error, "at_edge", (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
    json.set("fitted_amplitude_px", peak.amplitude, "fitted_amplitude_error_px", peak.amplitude_error);
    json.set("fitted_phase_rad", peak.phase, "fitted_offset_px", peak.offset, "fitted_time_offset_days", first_time);
    json.set("log10_fap", peak.log10_fap, "power_at_fap_1e-3", pipeline.latent.power_at_fap_1e_3);
}

void set_reconstructions(const Pipeline &pipeline, Json &json) {
    const Reconstructions &from = pipeline.reconstructions;
    json.set("mmse", from.mmse, "photon_floor", from.photon_floor, "mssim", from.mssim, "decoder",
             Json("cosine", pipeline.decoder_cosine, "gain", pipeline.decoder_gain));
    json.set("residuals",
             Json("frames", from.validation_frames, "mean", from.residual_mean, "rms", std::sqrt(from.residual_square),
                  "correlation", from.residual_product / from.residual_square));
    json.set("samples", from.samples);
}

void set_references(const Pipeline &pipeline, Json &json) {
    const toliman_period_peak &estimate = pipeline.estimate.peak, &truth = pipeline.truth.peak;
    json.set("template",
             Json("sigma_px", pipeline.estimate.sigma_px, "period_days", estimate.period, "period_error_days",
                  estimate.period_error, "log10_fap", estimate.log10_fap, "fwhm_period_days", estimate.fwhm_period));
    std::optional<Json> true_series;
    if (truth.period > 0)
        true_series.emplace("period_days", truth.period, "half_width_period_days", truth.half_width_period,
                            "fwhm_period_days", truth.fwhm_period, "log10_fap", truth.log10_fap);
    json.set("true_series", std::move(true_series), "controls", name_of(pipeline.controls));
    if (pipeline.controls == Controls::none) {
        json.set("no_signal", JsonTree(), "untrained", JsonTree());
        return;
    }
    json.set("no_signal", Json("log10_fap", pipeline.no_signal.peak.log10_fap, "frames", pipeline.control_frames));
    json.set("untrained",
             Json("log10_fap", pipeline.untrained.peak.log10_fap, "sigma_px", pipeline.untrained.sigma_px));
}

Json images_json(const std::vector<RunImage> &images) {
    Json list;
    for (size_t i = 0; i < images.size(); i++) {
        const RunImage &image = images[i];
        const std::string file = kRunImages[i];
        Json json("file", "images/" + file, "what", image.what, "unit", image.unit, "shape", image.shape, "axis_unit",
                  image.axis_unit, "first_x", image.first_x, "first_y", image.first_y, "step", image.step, "min_nm",
                  image.min_nm, "max_nm", image.max_nm, "reason", text_or_null(image.reason));
        list.set(file.substr(0, file.rfind('.')).c_str(), std::move(json));
    }
    return list;
}

Json timings_json(const Timings &spent) {
    return Json("setup_s", spent.setup, "simulate_s", spent.simulate, "train_s", spent.train, "encode_s", spent.encode,
                "period_s", spent.period, "controls_s", spent.controls, "images_s", spent.images, "total_s",
                spent.total);
}

std::string run_result(const RunFiles &files) {
    const Scene &scene = files.scene;
    const Pipeline &pipeline = files.pipeline;
    Json json("schema", "toliman-run/2", "version", toliman_version(), "provenance", provenance());
    set_scene(scene, pipeline.seed, json);
    set_brightest(scene, files.images[kExpectedImage], json);
    json.set("geometry", geometry(scene, files.rotation_deg));
    set_latent(pipeline, files.cadence.times[0], json);
    set_reconstructions(pipeline, json);
    set_references(pipeline, json);
    json.set("images", images_json(files.images), "grid",
             Json("f0", pipeline.grid.f0, "df", pipeline.grid.df, "nf", pipeline.grid.nf), "timings",
             timings_json(pipeline.timings));
    return json.text();
}

} // namespace

RunFolder::RunFolder(const std::string &path) : folder_(path), images_(folder_.file("images")) {
    for (const char *name : {"result.json", "series.csv", "periodogram.csv", "training.csv", "displacement.csv"})
        folder_.open(name);
    folder_.open("scene.json", Replaces::scenes);
    folder_.open("weights.tlmw");
    for (const char *name : kRunImages)
        images_.open(name);
}

std::string RunFolder::write(const RunFiles &files) {
    const Pipeline &pipeline = files.pipeline;
    const Cadence &cadence = files.cadence;
    const auto csv = [&](const char *name, const char *mark, const char *header, size_t rows,
                         const std::function<std::string(size_t)> &row) {
        OutputFile &out = folder_.open(name);
        out.write(std::string(mark) + header);
        for (size_t k = 0; k < rows; k++)
            out.write(row(k));
    };
    csv("series.csv", kSeriesMark, "frame,t,true,latent,template\n", cadence.times.size(), [&](size_t k) {
        return formatted("%zu,%.17g,%.17g,%.17g,%.17g\n", k, cadence.times[k], cadence.displacements[k],
                         pipeline.latents[k], pipeline.estimates[k]);
    });
    csv("periodogram.csv", kPeriodogramMark, "frequency,power,template,true\n", pipeline.latent.power.size(),
        [&](size_t k) {
            return formatted("%.17g,%.17g,%.17g,%.17g\n", pipeline.grid.f0 + pipeline.grid.df * static_cast<double>(k),
                             pipeline.latent.power[k], pipeline.estimate.power[k], pipeline.truth.power[k]);
        });
    csv("training.csv", kTrainingMark, "step,loss\n", pipeline.losses.size(),
        [&](size_t k) { return formatted("%zu,%.17g\n", k + 1, pipeline.losses[k]); });
    csv("displacement.csv", kDisplacementMark, "displacement_px,linear,cubic,linear_change,cubic_change,taylor\n",
        files.displacements.size(), [&](size_t k) {
            const DisplacementErrors &one = files.displacements[k];
            return formatted("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", one.displacement_px, one.linear, one.cubic,
                             one.linear_change, one.cubic_change, one.taylor);
        });
    folder_.open("scene.json").write(files.scene_text);
    folder_.open("weights.tlmw").write(pipeline.weights);
    std::string result = run_result(files);
    folder_.open("result.json").write(result);
    for (size_t i = 0; i < files.images.size(); i++)
        write_npy(images_.open(kRunImages[i]), files.images[i].values, files.images[i].shape);
    images_.commit();
    folder_.commit("result.json");
    return result;
}

} // namespace cli
