#include "experiment/run_folder.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/constants.hpp"
#include "common/provenance.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

using toliman::check;

void set_scene(const Scene &scene, uint64_t seed, Json &json) {
    const toliman_sim_info &info = scene.info;
    json.set("scene", toliman_sim_get_name(scene.sim.get())).set("seed", seed);
    json.set("scene_folder", std::filesystem::absolute(folder_of(scene.path)).lexically_normal().string());
    json.set("frames", info.frames).set("amplitude_px", info.amplitude_px);
    json.set("amplitude_uas", info.amplitude_uas);
    json.set("true_period_days", info.period_days).set("crb_px", info.crb_px);
    json.set("crb_flux_shift_px", info.crb_flux_shift_px)
        .set("crb_marginal_px", info.crb_marginal_px)
        .set("crb_projected_px", info.crb_projected_px);
}

// The expected frame's brightest pixel and its noise.
void set_brightest(const Scene &scene, const RunImage &expected, Json &json) {
    const auto brightest = std::max_element(expected.values.begin(), expected.values.end());
    const std::vector<double> variance = scene.image(TOLIMAN_SIM_IMAGE_VARIANCE);
    json.set("unit", unit_of(scene.info)).set("peak_counts", *brightest);
    json.set("peak_sigma", std::sqrt(variance[static_cast<size_t>(brightest - expected.values.begin())]));
}

// Stars and sky on the detector: +x to higher columns, +y to higher rows.
Json geometry(const Scene &scene, double rotation_deg) {
    constexpr double degree = toliman::kPi / 180;
    auto offsets = toliman::sized<toliman_sim_offsets>();
    check(toliman_sim_get_offsets(scene.sim.get(), &offsets));
    const double sine = std::sin(rotation_deg * degree), cosine = std::cos(rotation_deg * degree);
    Json json;
    json.set("aperture_m", scene.info.aperture_m).set("pixel_scale_arcsec", scene.info.pixel_scale_arcsec);
    json.set("a_x_px", offsets.a_x_px).set("a_y_px", offsets.a_y_px);
    json.set("b_x_px", offsets.b_x_px).set("b_y_px", offsets.b_y_px);
    json.set("north_x", sine).set("north_y", cosine).set("east_x", -cosine).set("east_y", sine);
    return json;
}

void set_latent(const Pipeline &pipeline, double first_time, Json &json) {
    const toliman_period_peak &peak = pipeline.latent.peak;
    json.set("latent_sigma_px", pipeline.latent.sigma_px);
    json.set("efficiency", pipeline.efficiency);
    json.set("efficiency_error", pipeline.efficiency / std::sqrt(2 * static_cast<double>(pipeline.control_frames)));
    json.set("cosine", pipeline.training.cosine).set("period_days", peak.period);
    json.set("half_width_period_days", peak.half_width_period).set("fwhm_period_days", peak.fwhm_period);
    json.set("period_error_days", peak.period_error);
    json.set("at_edge", (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
    json.set("fitted_amplitude_px", peak.amplitude).set("fitted_amplitude_error_px", peak.amplitude_error);
    json.set("fitted_phase_rad", peak.phase).set("fitted_offset_px", peak.offset);
    json.set("fitted_time_offset_days", first_time).set("log10_fap", peak.log10_fap);
    json.set("power_at_fap_1e-3", pipeline.false_alarm_power);
}

void set_references(const Pipeline &pipeline, Json &json) {
    const toliman_period_peak &estimate = pipeline.estimate.peak, &true_peak = pipeline.truth.peak;
    Json of_template, no_signal, untrained, truth;
    of_template.set("sigma_px", pipeline.estimate.sigma_px).set("period_days", estimate.period);
    of_template.set("period_error_days", estimate.period_error).set("log10_fap", estimate.log10_fap);
    of_template.set("fwhm_period_days", estimate.fwhm_period);
    no_signal.set("log10_fap", pipeline.no_signal.peak.log10_fap);
    no_signal.set("frames", pipeline.control_frames);
    untrained.set("log10_fap", pipeline.untrained.peak.log10_fap).set("sigma_px", pipeline.untrained.sigma_px);
    truth.set("period_days", true_peak.period).set("half_width_period_days", true_peak.half_width_period);
    truth.set("fwhm_period_days", true_peak.fwhm_period).set("log10_fap", true_peak.log10_fap);
    json.set("template", std::move(of_template));
    true_peak.period > 0 ? json.set("true_series", std::move(truth)) : json.set("true_series", nullptr);
    json.set("no_signal", std::move(no_signal)).set("untrained", std::move(untrained));
}

void set_reconstructions(const Pipeline &pipeline, Json &json) {
    const Reconstructions &from = pipeline.reconstructions;
    Json decoder, residuals;
    decoder.set("cosine", pipeline.decoder_cosine).set("gain", pipeline.decoder_gain);
    json.set("mmse", from.mmse).set("photon_floor", from.photon_floor).set("mssim", from.mssim);
    json.set("decoder", std::move(decoder));
    residuals.set("frames", from.validation_frames).set("mean", from.residual_mean);
    residuals.set("rms", std::sqrt(from.residual_square));
    residuals.set("correlation", from.residual_product / from.residual_square);
    json.set("residuals", std::move(residuals));
    json.set("samples", from.samples);
}

Json of_image(const char *name, const RunImage &image) {
    Json json;
    json.set("file", std::string("images/") + name + ".npy").set("what", image.what).set("unit", image.unit);
    json.set("shape", image.shape).set("axis_unit", image.axis_unit);
    json.set("first_x", image.first_x).set("first_y", image.first_y).set("step", image.step);
    json.set("min_nm", image.min_nm).set("max_nm", image.max_nm);
    image.reason.empty() ? json.set("reason", nullptr) : json.set("reason", image.reason);
    return json;
}

Json of_timings(const Timings &spent) {
    Json json;
    json.set("setup_s", spent.setup).set("simulate_s", spent.simulate).set("train_s", spent.train);
    json.set("encode_s", spent.encode).set("period_s", spent.period).set("controls_s", spent.controls);
    json.set("images_s", spent.images).set("total_s", spent.total);
    return json;
}

} // namespace

std::string run_result(const Scene &scene, double rotation_deg, const Cadence &cadence, const Pipeline &pipeline,
                       const std::vector<RunImage> &images) {
    Json json, grid, list;
    json.set("schema", "toliman-run/2").set("version", toliman_version()).set("provenance", provenance());
    set_scene(scene, pipeline.seed, json);
    set_brightest(scene, images[kExpectedImage], json);
    json.set("geometry", geometry(scene, rotation_deg));
    set_latent(pipeline, cadence.times[0], json);
    set_reconstructions(pipeline, json);
    set_references(pipeline, json);
    for (size_t i = 0; i < images.size(); i++)
        list.set(kRunImages[i], of_image(kRunImages[i], images[i]));
    json.set("images", std::move(list));
    grid.set("f0", pipeline.grid.f0).set("df", pipeline.grid.df).set("nf", pipeline.grid.nf);
    json.set("grid", std::move(grid)).set("timings", of_timings(pipeline.timings));
    return json.text();
}

} // namespace cli
