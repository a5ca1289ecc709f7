#include "frames/calibration_output.hpp"

#include <filesystem>

#include "common/npy.hpp"
#include "scenes/windows.hpp"

namespace cli {

namespace {

constexpr char kResult[] = ".calibration.json", kOpd[] = ".opd_change.npy";

// Images, and the files of them; the last is that of a response.
constexpr std::pair<int32_t, const char *> kImages[] = {
    {TOLIMAN_CALIBRATION_IMAGE_BEFORE, ".residual_before.npy"},
    {TOLIMAN_CALIBRATION_IMAGE_AFTER, ".residual_after.npy"},
    {TOLIMAN_CALIBRATION_IMAGE_CHI, ".chi_map.npy"},
    {TOLIMAN_CALIBRATION_IMAGE_RESPONSE_SIGMA, ".response_sigma.npy"}};

// Parameters and covariance of a window.
struct Window {
    Window(const Calibration &calibration, const toliman_calibration_info &info, int64_t number)
        : about(toliman::sized<toliman_calibration_window>()),
          covariance(static_cast<size_t>(info.parameters * info.parameters)) {
        const toliman_calibration *const made = calibration.get();
        toliman::check(toliman_calibration_get_window(made, number, &about));
        for (int64_t i = 0; i < info.parameters; i++) {
            values.push_back(toliman::sized<toliman_calibration_value>());
            toliman::check(toliman_calibration_get_value(made, number, i, &values.back()));
        }
        toliman::check(toliman_calibration_get_covariance(made, number, covariance.data()));
    }
    toliman_calibration_window about;
    std::vector<toliman_calibration_value> values;
    std::vector<double> covariance; // [n][n]
};

struct Results {
    explicit Results(const Calibration &calibration)
        : info(toliman::result<toliman_calibration_info>(toliman_calibration_get_info, calibration.get())),
          attempts(items_of(toliman_calibration_get_attempt, calibration.get(), info.attempts)),
          left_out(items_of(toliman_calibration_get_left_out, calibration.get(), info.left_out)) {
        for (int64_t i = 0; i < info.windows; i++)
            windows.emplace_back(calibration, info, i);
    }
    toliman_calibration_info info;
    std::vector<toliman_calibration_attempt> attempts;
    std::vector<toliman_calibration_left_out> left_out;
    std::vector<Window> windows;
};

bool has(uint32_t flags, uint32_t flag) {
    return (flags & flag) != 0;
}

std::string chi_square_of(const toliman_calibration_info &info) {
    const double sigmas = (info.chi_square - 1) / info.chi_square_sigma;
    return formatted("chi-square %.6g is %.3g sigma %s 1", info.chi_square, std::fabs(sigmas),
                     sigmas < 0 ? "below" : "above");
}

// Why the model is incomplete.
std::string excess_of(const toliman_calibration_info &info) {
    if (info.structure > info.structure_limit && info.goodness != TOLIMAN_GOODNESS_POOR) {
        const Apart structure = apart(info.structure, info.structure_limit, 3);
        return "residuals of neighbouring pixels are correlated: " + structure.value + ", at most " + structure.limit +
               " without structure";
    }
    return chi_square_of(info);
}

constexpr uint32_t kChanges[] = {TOLIMAN_CALIBRATION_CHANGE_EDGES, TOLIMAN_CALIBRATION_CHANGE_SAMPLES,
                                 TOLIMAN_CALIBRATION_CHANGE_SPECTRUM, TOLIMAN_CALIBRATION_CHANGE_WINDOWS,
                                 TOLIMAN_CALIBRATION_CHANGE_OPD_MAP};

std::vector<std::string> names_of(uint32_t changes) {
    std::vector<std::string> names;
    for (const uint32_t change : kChanges)
        if (has(changes, change))
            names.emplace_back(toliman_constant_name(static_cast<int32_t>(change)));
    return names;
}

// What a person would change in the scene or the command.
std::string lack_of(uint32_t change, const toliman_calibration_info &info) {
    switch (change) {
    case TOLIMAN_CALIBRATION_CHANGE_EDGES:
        return "mask edges (telescope.mask.edges = \"area\")";
    case TOLIMAN_CALIBRATION_CHANGE_SAMPLES:
        return formatted("pupil samples (telescope.pupil_samples = %lld: expected error %.2g of the peak, photon noise "
                         "%.2g)",
                         static_cast<long long>(info.cells), info.pupil_error, info.peak_noise);
    case TOLIMAN_CALIBRATION_CHANGE_SPECTRUM:
        return "spectral modes (--free with spectrum_a_1-2 spectrum_b_1-2)";
    case TOLIMAN_CALIBRATION_CHANGE_WINDOWS:
        return "changes with time (--windows)";
    default:
        return "a map (--map)";
    }
}

std::string lacks_of(const toliman_calibration_info &info) {
    std::vector<std::string> lacks;
    for (const uint32_t change : kChanges)
        if (has(info.lacks, change))
            lacks.push_back(lack_of(change, info));
    return joined(lacks);
}

std::string names_with(const std::vector<Window> &windows, uint32_t flag) {
    std::vector<std::string> names;
    for (const Window &window : windows)
        for (const auto &value : window.values)
            if (has(value.flags, flag) && std::find(names.begin(), names.end(), value.name) == names.end())
                names.emplace_back(value.name);
    return joined(names);
}

// The verdict in sentences, the main one first.
std::vector<std::string> verdict_of(const Results &results) {
    const toliman_calibration_info &info = results.info;
    std::vector<std::string> sentences;
    if (has(info.flags, TOLIMAN_CALIBRATION_INCOMPLETE))
        sentences.push_back("converged, but the model is incomplete: " + excess_of(info));
    if (has(info.flags, TOLIMAN_CALIBRATION_TOO_GOOD))
        sentences.push_back("converged, but chi-square is too good: " + chi_square_of(info));
    if (sentences.empty())
        sentences.emplace_back("converged; the model is complete");
    if (info.lacks != 0)
        sentences.push_back("may be missing: " + lacks_of(info));
    if (info.changes != 0)
        sentences.push_back("added to the model: " + joined(names_of(info.changes)));
    const std::string held = names_with(results.windows, TOLIMAN_CALIBRATION_HELD);
    if (!held.empty())
        sentences.push_back("known mostly by the prior: " + held);
    if (has(info.flags, TOLIMAN_CALIBRATION_NO_SIGN))
        sentences.emplace_back("the frames do not determine the sign of even aberrations");
    return sentences;
}

Json json_of(const toliman_calibration_value &value) {
    return Json("name", value.name, "unit", value.unit, "value", Exact{value.value}, "sigma", Exact{value.sigma},
                "prior_sigma", value.prior_sigma, "held", has(value.flags, TOLIMAN_CALIBRATION_HELD), "no_sign",
                has(value.flags, TOLIMAN_CALIBRATION_NO_SIGN));
}

Json json_of(const Window &window, const std::string &scene) {
    const size_t n = window.values.size();
    std::vector<std::vector<double>> covariance;
    for (size_t i = 0; i < n; i++)
        covariance.emplace_back(&window.covariance[i * n], &window.covariance[i * n] + n);
    return Json("first_days", Exact{window.about.first_days}, "frames", window.about.frames, "chi_square",
                window.about.chi_square, "chi_square_sigma", window.about.chi_square_sigma, "largest_residual",
                window.about.largest_residual, "goodness", toliman_constant_name(window.about.goodness), "scene", scene,
                "parameters", array_of(window.values, [](const auto &value) { return json_of(value); }), "covariance",
                covariance);
}

Json json_of_frame(const Calibration &calibration, size_t i) {
    auto result = toliman::sized<toliman_fit_result>();
    toliman::check(toliman_calibration_get_frame(calibration.get(), static_cast<int64_t>(i), &result));
    const FrameSet &frames = calibration.frames();
    return Json("file", frames.places[i].file, "frame", frames.places[i].frame, "time_days",
                Exact{frames.predictions[i].time_days}, "separation_px", Exact{result.separation_px},
                "separation_sigma_px", result.separation_sigma_px, "displacement_px", Exact{result.displacement_px},
                "position_angle_deg", Exact{result.position_angle_deg}, "x_px", Exact{result.x_px}, "y_px",
                Exact{result.y_px}, "flux_a", result.flux_a, "flux_b", result.flux_b, "background", result.background,
                "chi_square", result.chi_square, "excluded", result.excluded);
}

Json json_of(const toliman_calibration_step &step) {
    std::optional<std::string> change;
    if (step.change != 0)
        change = toliman_constant_name(static_cast<int32_t>(step.change));
    return Json("change", change, "map", step.is_map != 0, "response", step.is_response != 0, "iteration",
                step.iteration, "accepted", step.accepted != 0, "chi_square", step.chi_square, "largest_step",
                step.largest_step);
}

Json json_of(const toliman_calibration_attempt &attempt) {
    return Json("change", toliman_constant_name(static_cast<int32_t>(attempt.change)), "kept", attempt.kept != 0,
                "converged", !has(attempt.flags, TOLIMAN_CALIBRATION_NOT_CONVERGED), "cells", attempt.cells,
                "chi_square", attempt.chi_square, "chi_square_sigma", attempt.chi_square_sigma, "largest_residual",
                attempt.largest_residual, "goodness", toliman_constant_name(attempt.goodness));
}

Json json_of(const toliman_calibration_left_out &left_out) {
    return Json("name", left_out.name, "reason", left_out.reason);
}

std::string name_of(const std::string &path) {
    return std::filesystem::path(path).filename().string();
}

// Throws Failure if the scenes cannot be written.
const CalibrationFiles &checked(const CalibrationFiles &files) {
    for (const std::string &path : {files.out(), files.journal()})
        const OutputFile probe(path, Replaces::scenes);
    return files;
}

void print_window(const Window &window, size_t number, size_t count) {
    if (count > 1)
        std::printf("\nwindow %zu: from %g days, %lld %s, chi-square %.6g\n", number + 1,
                    std::round(1e6 * window.about.first_days) / 1e6, static_cast<long long>(window.about.frames),
                    window.about.frames == 1 ? "frame" : "frames", window.about.chi_square);
    std::printf("\n%-14s %28s %-6s %8s\n", "parameter", "value +- sigma", "unit", "prior");
    for (const auto &value : window.values)
        std::printf("%-14s %28s %-6s %8.3g%s%s\n", value.name, text_with_error(value.value, value.sigma).c_str(),
                    value.unit, value.prior_sigma, has(value.flags, TOLIMAN_CALIBRATION_HELD) ? "  prior" : "",
                    has(value.flags, TOLIMAN_CALIBRATION_NO_SIGN) ? "  sign unknown" : "");
}

void print_attempt(const toliman_calibration_attempt &attempt) {
    const bool of_cells = attempt.change == TOLIMAN_CALIBRATION_CHANGE_SAMPLES;
    const bool converged = !has(attempt.flags, TOLIMAN_CALIBRATION_NOT_CONVERGED);
    std::printf("tried        %s%s: %s, %s\n", toliman_constant_name(static_cast<int32_t>(attempt.change)),
                of_cells ? formatted(" %lld", static_cast<long long>(attempt.cells)).c_str() : "",
                converged ? ("chi-square " + text_with_error(attempt.chi_square, attempt.chi_square_sigma) + ", " +
                             toliman_constant_name(attempt.goodness))
                                .c_str()
                          : "did not converge",
                attempt.kept != 0 ? "kept" : "not kept");
}

bool is_complete(const toliman_calibration_info &info) {
    return !has(info.flags, TOLIMAN_CALIBRATION_INCOMPLETE | TOLIMAN_CALIBRATION_TOO_GOOD);
}

} // namespace

CalibrationOutput::CalibrationOutput(const CalibrationFiles &files, bool has_response)
    : files_(checked(files)), has_response_(has_response), out_(files.stem()) {
    for (const char *name : {kResult, kOpd})
        out_.open(name);
    for (const auto &[kind, name] : kImages)
        if (has_response || kind != TOLIMAN_CALIBRATION_IMAGE_RESPONSE_SIGMA)
            out_.open(name);
}

void CalibrationOutput::write(const Calibration &calibration) {
    const Results results(calibration);
    const toliman_calibration_info &info = results.info;
    const std::vector<Window> &windows = results.windows;
    std::vector<Json> of_windows, of_frames;
    for (size_t i = 0; i < windows.size(); i++)
        of_windows.push_back(json_of(windows[i], name_of(files_.scene(i, windows.size()))));
    for (size_t i = 0; i < calibration.frames().places.size(); i++)
        of_frames.push_back(json_of_frame(calibration, i));
    Json json("schema", "toliman-calibration-result/1", "version", toliman_version(), "provenance", provenance(),
              "scene", calibration.request().scene, "out", name_of(files_.out()), "verdict", verdict_of(results),
              "complete", is_complete(info), "held", has(info.flags, TOLIMAN_CALIBRATION_HELD), "no_sign",
              has(info.flags, TOLIMAN_CALIBRATION_NO_SIGN));
    json.set("frames", info.frames, "rows", info.rows, "cols", info.cols, "cells", info.cells, "iterations",
             info.iterations, "map_iterations", info.map_iterations, "chi_square", info.chi_square, "chi_square_sigma",
             info.chi_square_sigma, "largest_residual", info.largest_residual, "goodness",
             toliman_constant_name(info.goodness), "structure", info.structure, "structure_limit", info.structure_limit,
             "separation_sigma_px", info.separation_sigma_px, "calibration_sigma_px", info.calibration_sigma_px,
             "map_rms_nm", info.map_rms_nm, "map_parameters", info.map_parameters, "response_iterations",
             info.response_iterations, "response_pixels", info.response_pixels, "response_rms", info.response_rms,
             "response_parameters", info.response_parameters, "pupil_error", info.pupil_error, "peak_noise",
             info.peak_noise);
    json.set("lacks", names_of(info.lacks), "changes", names_of(info.changes), "attempts",
             array_of(results.attempts, [](const auto &attempt) { return json_of(attempt); }), "left_out",
             array_of(results.left_out, [](const auto &left_out) { return json_of(left_out); }));
    json.set("windows", of_windows, "separations", of_frames, "steps",
             array_of(calibration.steps(), [](const auto &step) { return json_of(step); }));
    json_ = json.text();
    out_.open(kResult).write(json_);
    write_arrays(calibration, info);
    out_.commit(kResult, [&] { write_scenes(calibration, windows.size()); });
}

// With several windows their list is written last, as it implies that their scenes are complete.
void CalibrationOutput::write_scenes(const Calibration &calibration, size_t windows) const {
    std::vector<WindowScene> list;
    for (size_t i = 0; i < windows; i++) {
        const std::string path = files_.scene(i, windows);
        const OutputFile probe(path, Replaces::scenes);
        toliman::check(toliman_calibration_save_file(calibration.get(), static_cast<int64_t>(i), path.c_str()));
        auto window = toliman::sized<toliman_calibration_window>();
        toliman::check(toliman_calibration_get_window(calibration.get(), static_cast<int64_t>(i), &window));
        list.push_back({window.first_days, name_of(path)});
    }
    if (windows == 1)
        return;
    OutputFile out(files_.out(), Replaces::scenes);
    out.write(window_list(list));
    out.commit();
}

void CalibrationOutput::write_arrays(const Calibration &calibration, const toliman_calibration_info &info) {
    const toliman_calibration *const made = calibration.get();
    const auto rows = static_cast<size_t>(info.rows), cols = static_cast<size_t>(info.cols),
               cells = static_cast<size_t>(info.cells), windows = static_cast<size_t>(info.windows);
    std::vector<double> image(rows * cols), opd(windows * cells * cells);
    for (const auto &[kind, name] : kImages) {
        if (!has_response_ && kind == TOLIMAN_CALIBRATION_IMAGE_RESPONSE_SIGMA)
            continue;
        toliman::check(toliman_calibration_get_image(made, kind, image.data(), cols));
        write_npy(out_.open(name), image, {rows, cols});
    }
    for (size_t i = 0; i < windows; i++)
        toliman::check(toliman_calibration_get_opd(made, static_cast<int64_t>(i), &opd[i * cells * cells]));
    write_npy(out_.open(kOpd), opd, {windows, cells, cells});
}

void CalibrationOutput::warn(const Calibration &calibration, Progress &progress) const {
    const Results results(calibration);
    const toliman_calibration_info &info = results.info;
    const bool improved = has(calibration.request().options.flags, TOLIMAN_CALIBRATION_IMPROVE);
    for (const auto &left_out : results.left_out)
        progress.warn(std::string(left_out.name) + " is not fitted: " + left_out.reason);
    if (has(info.flags, TOLIMAN_CALIBRATION_TOO_GOOD))
        progress.warn("the noise of the frames is smaller than that of the scene: " + chi_square_of(info) +
                      ": check noise.read_e, detector.bias_dn, detector.gain_e_per_dn and the unit of the frames");
    if (!has(info.flags, TOLIMAN_CALIBRATION_INCOMPLETE))
        return;
    progress.warn("the model is incomplete: " + excess_of(info) +
                  ": the frames have an effect that it lacks, and separations may be wrong by more than their sigma: " +
                  (info.lacks == 0 ? "free more parameters (--free)"
                                   : (improved ? "may still be missing: " : "may be missing: ") + lacks_of(info) +
                                         (improved ? "" : "; --improve tries them in this order")) +
                  (has_response_ ? "" : "; a flat field that the scene lacks: --detector"));
}

void CalibrationOutput::print(const Calibration &calibration) const {
    const Results results(calibration);
    const toliman_calibration_info &info = results.info;
    const std::vector<Window> &windows = results.windows;
    for (const std::string &sentence : verdict_of(results))
        std::printf("%s\n", sentence.c_str());
    std::printf("\nframes       %lld, in %lld %s\n", static_cast<long long>(info.frames),
                static_cast<long long>(info.windows), info.windows == 1 ? "window" : "windows");
    std::printf("iterations   %d of the parameters%s%s\n", info.iterations,
                info.response_iterations > 0 ? formatted(", %d of the response", info.response_iterations).c_str() : "",
                info.map_iterations > 0 ? formatted(", %d of the map", info.map_iterations).c_str() : "");
    std::printf("chi-square   %s per degree of freedom, %s; largest residual %.1f sigma\n",
                text_with_error(info.chi_square, info.chi_square_sigma).c_str(), toliman_constant_name(info.goodness),
                info.largest_residual);
    std::printf(
        "separation   sigma %.3g px per frame; the error of the calibration, common to all frames, adds %.3g px\n",
        info.separation_sigma_px, info.calibration_sigma_px);
    if (info.map_iterations > 0)
        std::printf("map          %.3g nm rms over the open pupil, as good as %.0f parameters\n", info.map_rms_nm,
                    info.map_parameters);
    if (info.response_iterations > 0)
        std::printf("response     %.3g rms of %lld pixels that the frames determine, as good as %.0f parameters; %lld "
                    "pixels remain at the prior\n",
                    info.response_rms, static_cast<long long>(info.response_pixels), info.response_parameters,
                    static_cast<long long>(info.rows * info.cols - info.response_pixels));
    for (const auto &attempt : results.attempts)
        print_attempt(attempt);
    for (const auto &left_out : results.left_out)
        std::printf("not fitted   %s: %s\n", left_out.name, left_out.reason);
    for (size_t i = 0; i < windows.size(); i++)
        print_window(windows[i], i, windows.size());
    const std::string out = files_.out();
    if (has(info.flags, TOLIMAN_CALIBRATION_INCOMPLETE))
        std::printf("\nDo not search planets with it: give the command again with --improve for the optics, with\n"
                    "--detector for a flat field or smear\n");
    else
        std::printf("\nuse: toliman encode --fit %s FRAMES, toliman track --fit %s\n"
                    "A new calibration is a new estimator: ingest all frames again, from the first one, into a new "
                    "state folder.\n",
                    out.c_str(), out.c_str());
    print_stdout("");
}

} // namespace cli
