// The numerical model is part of a calibration: with 128 pupil cells for 256, or 20 wavelengths for 40, aberrations
// that were fitted for the other one leave errors of 1e-5 to 1e-3 px. A fitted scene names what it was calibrated with,
// and states whether its model explained the frames.
#include "scene/groups.hpp"

namespace toliman::scene {

namespace {

constexpr const char kAgain[] = "calibrate the scene again, or change it back";

void check_samples(const Reader &reader, const Row &row, Scene &scene) {
    const int64_t samples = reader.integer(row);
    if (samples != static_cast<int64_t>(scene.telescope.pupil_samples))
        reader.refuse(Status::scene, row.key, " = %lld, but telescope.pupil_samples = %zu: %s",
                      static_cast<long long>(samples), scene.telescope.pupil_samples, kAgain);
}

void check_step(const Reader &reader, const Row &row, Scene &scene) {
    const double step_nm = reader.number(row);
    const double given = scene.band && scene.band->steps > 0
                             ? (scene.band->max_nm - scene.band->min_nm) / static_cast<double>(scene.band->steps)
                             : 0;
    if (!(given > 0.999999 * step_nm && given < 1.000001 * step_nm))
        reader.refuse(Status::scene, row.key, " = %g, but band.step_nm = %g: %s", step_nm, given, kAgain);
}

void check_edges(const Reader &reader, const Row &row, Scene &scene) {
    if (static_cast<Mask::Edges>(reader.choice(row)) != scene.telescope.mask.edges)
        reader.refuse(Status::scene, row.key, ": telescope.mask.edges is the other one: %s", kAgain);
}

void check_accuracy(const Reader &reader, const Row &row, Scene &scene) {
    const double accuracy = reader.number(row);
    if (scene.accuracy > accuracy)
        reader.refuse(Status::scene, row.key, " = %g, but accuracy = %g: %s", accuracy, scene.accuracy, kAgain);
}

SceneCalibration &verdict_of(Scene &scene) {
    if (!scene.calibration)
        scene.calibration.emplace();
    return *scene.calibration;
}

template <double Goodness::*member> void read_number(const Reader &reader, const Row &row, Scene &scene) {
    verdict_of(scene).goodness.*member = reader.number(row);
}

// Words of a choice have no spaces, unlike "too good".
void read_goodness(const Reader &reader, const Row &row, Scene &scene) {
    const std::string &text = reader.text(row.key);
    for (const GoodnessVerdict verdict :
         {GoodnessVerdict::unknown, GoodnessVerdict::good, GoodnessVerdict::poor, GoodnessVerdict::too_good})
        if (text == name_of(verdict)) {
            verdict_of(scene).goodness.verdict = verdict;
            return;
        }
    reader.refuse(Status::scene, row.key, R"( = "%.40s": must be "good", "poor", "too good" or "unknown")",
                  text.c_str());
}

void read_complete(const Reader &reader, const Row &row, Scene &scene) {
    verdict_of(scene).complete = reader.boolean(row.key);
}

void read_frames(const Reader &reader, const Row &row, Scene &scene) {
    verdict_of(scene).frames = reader.integer(row);
}

constexpr Condition kOfVerdict = with("goodness", "belongs to a verdict");

constexpr Row kRows[] = {
    optional<check_samples>("pupil_samples", within(8, kMostPupilSamples, "samples"),
                            "telescope.pupil_samples of the calibration")
        .as(Type::integer),
    optional<check_step>("step_nm", above(0, 1e6, "nm"), "band.step_nm of the calibration").as(Type::number),
    optional<check_edges>("edges", Words{"cell area"}, "telescope.mask.edges of the calibration"),
    optional<check_accuracy>("accuracy", within(1e-15, 1), "accuracy of the calibration; the scene's may be smaller")
        .as(Type::number),
    optional<read_goodness>("goodness", "Verdict on chi_square: good, poor, too good, or unknown").as(Type::text),
    optional<read_number<&Goodness::chi_square>>("chi_square", within(0, 1e300),
                                                 "Sum of squared residuals over their variances, per degree of freedom")
        .as(Type::number)
        .when(kOfVerdict),
    optional<read_number<&Goodness::sigma>>("chi_square_sigma", within(0, 1e300),
                                            "Standard deviation of chi_square, if the model is right")
        .as(Type::number)
        .when(kOfVerdict),
    optional<read_number<&Goodness::largest>>("largest_residual", within(0, 1e300),
                                              "Largest residual, in its standard deviations")
        .as(Type::number)
        .when(kOfVerdict),
    optional<read_complete>("complete", "Whether the model explained the frames").as(Type::boolean).when(kOfVerdict),
    optional<read_frames>("frames", within(0, 9e15),
                          "Number of frames of the calibration, or from this start of a window to the next")
        .as(Type::integer)
        .when(kOfVerdict),
};

} // namespace

constexpr Group kCalibration = group_of(
    "calibration",
    "What a fitted scene was calibrated with, and whether it fitted (toliman calibrate): a scene that contradicts the "
    "former is refused",
    kRows);

// A file without a verdict has none that is good.
void note_calibration(const Reader &reader, Scene &scene) {
    verdict_of(scene).stated = reader.object("calibration").has("goodness");
}

} // namespace toliman::scene
