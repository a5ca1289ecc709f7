// toliman plan: approximations, errors and cost of a scene, before anything is computed.
#include <thread>

#include "options/command.hpp"
#include "scenes/scene.hpp"

namespace cli {

namespace {

struct PlanOptions {
    std::string scene, engine = "auto";
    bool as_json = false;
};

std::string stages(const toliman_sim_plan_info &plan, bool there) {
    std::vector<std::string> names;
    for (const toliman_sim_stage &stage : stages_of(plan))
        if ((stage.modelled != 0) == there)
            names.emplace_back(stage.name);
    return names.empty() ? "nothing" : joined(names);
}

const char *engine_name(const toliman_sim_plan_info &plan) noexcept {
    return plan.engine == TOLIMAN_SIM_ENGINE_PADDED_FFT ? "padded FFT" : "matrix DFT";
}

// N_E = N_out p D/lambda must be a whole number.
std::string fft_cells(const toliman_sim_plan_info &plan) {
    return formatted("N_E %lld to %lld, whole, of N_out %lld", static_cast<long long>(plan.fft_cells[0]),
                     static_cast<long long>(plan.fft_cells[1]), static_cast<long long>(plan.fft_side));
}

constexpr char kAbove[] = "  > accuracy", kRounding[] = "  > accuracy: rounding of double precision";

// States which results the pupil error affects.
void print_pupil_note(const toliman_sim_plan_info &plan) {
    if (plan.pupil_error > plan.accuracy)
        std::printf(
            "              The pupil error compares the mask drawn on these cells with the ideal mask. Frames,\n"
            "              template and network of a scene use the same cells, so periods in its frames are not\n"
            "              disturbed, but the image of a real mask differs by this error. Frames of a real mask\n"
            "              need an error below their photon noise: telescope.mask.edges \"area\" and more\n"
            "              telescope.pupil_samples (at most 2048) reduce it.\n");
}

// What needs the set-up of the scene.
struct SetUp {
    std::optional<toliman_sim_bounds> image;
    // The bank of networks for the frames of moving stars: its plan, or why there can be none.
    std::optional<toliman_bank_plan_info> bank;
    std::string no_bank;
};

constexpr double kShort = 5; // s: a set-up that the properties of the image are worth

// The properties of the image, if the set-up is short, and the bank of moving stars, whose places need the simulator.
SetUp set_up(const std::string &path, const toliman_sim_plan_info &plan, Progress &progress) {
    SetUp found;
    const bool moving = has_stage(plan, "moving stars"), is_short = plan.setup_s <= kShort;
    if (!moving && !is_short)
        return found;
    auto silent = with_progress<toliman_sim_options>(progress); // the plan has given the warnings
    try {
        const Scene scene(path, silent);
        if (is_short)
            found.image = scene.bounds();
        progress.clear();
        auto bank = toliman::sized<toliman_bank_plan_info>();
        if (moving)
            toliman::check(toliman_bank_plan(scene.sim.get(), nullptr, &bank));
        found.bank = if_known(moving, bank);
    } catch (const toliman::error &error) { // the plan of the scene is printed nevertheless
        stop_if_asked();
        if (moving)
            found.no_bank = error.what();
    }
    return found;
}

void print_bank(const toliman_bank_plan_info &info) {
    const auto networks = static_cast<unsigned>(info.networks), places = static_cast<unsigned>(info.places);
    const unsigned processors = std::clamp(std::thread::hardware_concurrency(), 1u, networks);
    std::printf("bank          %u networks (places x dates: %u x %u), %s as float32, %s as fp16, %.2g s to train\n",
                networks, places, networks / places, size_text(static_cast<double>(info.bytes_float32)).c_str(),
                size_text(static_cast<double>(info.bytes_half)).c_str(), info.train_s / processors);
}

// The light of a star, from the telescope to the charge, as far as the scene gives it.
void print_light(const toliman_sim_plan_info &plan, int star) {
    if (plan.electrons_per_s[star] == 0)
        return;
    const double photons = plan.photons_per_s[star], electrons = plan.electrons_per_s[star];
    std::string chain;
    if (!std::isnan(plan.magnitude[star]))
        chain += formatted("%.4g mag: ", plan.magnitude[star]);
    if (photons > 0)
        chain += formatted("%.4g photons/s at the telescope x %.4g = %.4g at the focal plane x qe %.4g = ",
                           photons / plan.throughput[star], plan.throughput[star], photons, electrons / photons);
    std::printf("star %c        %s%.4g electrons/s\n", "AB"[star], chain.c_str(), electrons);
}

void print_summary(const toliman_sim_plan_info &plan, const SetUp &found) {
    std::printf("modelled      %s\n", stages(plan, true).c_str());
    std::printf("not modelled  %s\n", stages(plan, false).c_str());
    for (int star = 0; star < 2; star++)
        print_light(plan, star);
    std::printf("accuracy      %.2g requested                            error/peak\n", plan.accuracy);
    const auto line = [&](const char *what, const std::string &how, double error, const char *of,
                          const char *above = kAbove) {
        std::printf("%-13s %-42s %.1e%s%s\n", what, how.c_str(), error, of, error > plan.accuracy ? above : "");
    };
    line("engine", engine_name(plan), plan.rounding_error, "", kRounding);
    if (plan.plate_scale_error > 0)
        line("plate scale", fft_cells(plan), plan.plate_scale_error, " relative, different per wavelength");
    const std::string samples = std::to_string(plan.pupil_samples);
    line("pupil", samples + " x " + samples + " cells", plan.pupil_error, "", "  > accuracy: see below");
    line("wavelengths",
         plan.wavelengths < plan.scene_wavelengths
             ? std::to_string(plan.wavelengths) + " nodes for the scene's " + std::to_string(plan.scene_wavelengths)
             : "all " + std::to_string(plan.wavelengths),
         plan.spectrum_error, "");
    if (plan.exact_frames != 0)
        line("frames", "every frame propagated", plan.rounding_error, "", kRounding);
    else if (plan.atlas_taps > 0)
        line("places",
             "window of " + std::to_string(plan.atlas_taps) + ", " + std::to_string(plan.atlas_oversampling) +
                 " sample(s) per pixel",
             plan.atlas_error, "");
    else // the order meets the accuracy: an error above it is the rounding of a very small signal
        line("displacement", "expansion of order " + std::to_string(plan.order), plan.series_error, " of the signal",
             kRounding);
    if (plan.filter_taps > 0)
        line("pixels",
             std::to_string(plan.oversampling) + " sample(s) per side, filter of " + std::to_string(plan.filter_taps),
             plan.pixel_error, "");
    else
        line("pixels", "sampled at their centres", 0, "");
    if (plan.bad_pixels > 0)
        std::printf("bad pixels    %lld, which no estimator uses\n", static_cast<long long>(plan.bad_pixels));
    print_pupil_note(plan);
    std::printf("set-up        %.3g GFLOP, %.2g s\n", plan.setup_flops * 1e-9, plan.setup_s);
    std::printf("per frame     %.3g MFLOP, %.2g ms including noise\n", plan.frame_flops * 1e-6, plan.frame_s * 1e3);
    std::printf("memory        %s on all processors\n", size_text(plan.bytes).c_str());
    if (found.image)
        std::printf("image         peak-to-mean %.3g, gradient energy %.3g px^-2\n", found.image->peak_to_mean,
                    found.image->gradient_energy);
    if (found.bank)
        print_bank(*found.bank);
    if (!found.no_bank.empty())
        std::printf("bank          none: %s\n", found.no_bank.c_str());
    print_stdout("");
}

Json bank_json(const toliman_bank_plan_info &info) {
    return Json("networks", info.networks, "places", info.places, "dates", info.dates, "first_days", info.first_days,
                "last_days", info.last_days, "bytes_float32", info.bytes_float32, "bytes_half", info.bytes_half,
                "train_s", info.train_s);
}

std::string as_json(const toliman_sim_plan_info &plan, const SetUp &found, const std::string &scene) {
    Json stages_there;
    for (const toliman_sim_stage &stage : stages_of(plan))
        stages_there.set(stage.name, stage.modelled);
    Json json("schema", "toliman-plan/1", "scene", scene, "engine", engine_name(plan), "accuracy", plan.accuracy);
    json.set("scene_wavelengths", plan.scene_wavelengths, "wavelengths", plan.wavelengths, "order", plan.order);
    json.set("exact_frames", plan.exact_frames, "orbit_px", plan.orbit_px);
    json.set("atlas_taps", plan.atlas_taps, "atlas_oversampling", plan.atlas_oversampling);
    json.set("oversampling", plan.oversampling, "filter_taps", plan.filter_taps);
    json.set("fft_side", plan.fft_side, "fewest_fft_cells", plan.fft_cells[0], "most_fft_cells", plan.fft_cells[1]);
    json.set("pupil_samples", plan.pupil_samples, "stages", std::move(stages_there));
    json.set("errors", Json("rounding", plan.rounding_error, "pupil", plan.pupil_error, "spectrum", plan.spectrum_error,
                            "series", plan.series_error, "pixel", plan.pixel_error, "atlas", plan.atlas_error,
                            "plate_scale", plan.plate_scale_error));
    std::vector<Json> stars;
    for (int star = 0; star < 2; star++)
        if (plan.throughput[star] > 0) // there is this star
            stars.emplace_back("magnitude", plan.magnitude[star], "throughput", plan.throughput[star], "photons_per_s",
                               if_known(plan.photons_per_s[star] > 0, plan.photons_per_s[star]), "electrons_per_s",
                               if_known(plan.electrons_per_s[star] > 0, plan.electrons_per_s[star]));
    json.set("open_area_m2", plan.open_area_m2, "stars", std::move(stars));
    json.set("setup_flops", plan.setup_flops, "frame_flops", plan.frame_flops, "bytes", plan.bytes);
    json.set("setup_s", plan.setup_s, "frame_s", plan.frame_s);
    const auto of_image = [&](double toliman_sim_bounds::*value) {
        return found.image ? std::optional((*found.image).*value) : std::nullopt;
    };
    json.set("peak_to_mean", of_image(&toliman_sim_bounds::peak_to_mean), "gradient_energy",
             of_image(&toliman_sim_bounds::gradient_energy));
    json.set("bank", found.bank ? std::optional(bank_json(*found.bank)) : std::nullopt);
    return json.text();
}

void plan(const PlanOptions &options, Progress &progress) {
    auto how = toliman::sized<toliman_sim_options>();
    how.log = Progress::log;
    how.log_data = &progress;
    how.engine = options.engine == "fft"    ? TOLIMAN_SIM_ENGINE_PADDED_FFT
                 : options.engine == "mdft" ? TOLIMAN_SIM_ENGINE_MATRIX_DFT
                                            : 0;
    auto found = toliman::sized<toliman_sim_plan_info>();
    const std::string path = scene_path(options.scene, how);
    toliman::check(toliman_sim_plan_file(path.c_str(), &how, &found));
    const SetUp computed = set_up(path, found, progress);
    if (options.as_json)
        print_stdout(as_json(found, computed, options.scene));
    else
        print_summary(found, computed);
}

} // namespace

void add_plan(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "plan");
    auto options = std::make_shared<PlanOptions>();
    add_scene(*command, options->scene);
    add_choice(command, "--engine", options->engine, {"auto", "mdft", "fft"});
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, plan);
}

} // namespace cli
