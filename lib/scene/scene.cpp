#include "scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/hash.hpp"
#include "base/name.hpp"
#include "frame/frame_model.hpp"
#include "scene/geometry.hpp"
#include "scene/groups.hpp"
#include "scene/wobble.hpp"
#include "sky/time.hpp"

namespace toliman::scene {

namespace {

constexpr double kFirstDate = 1901, kLastDate = 2099; // of the Earth's ephemeris
constexpr double kLargestWhole = 9007199254740991.0;  // 2^53 - 1: larger ones become doubles in other programs

void read_scene_name(const Reader &reader, const Row &row, Scene &scene) {
    scene.name = reader.text(row.key);
    if (!is_name(scene.name))
        reader.refuse(Status::scene, row.key, " = \"%.40s\": %s", scene.name.c_str(), kNameRule);
}

void check_stars(const Reader &reader, const Scene &scene) {
    const bool continuous = std::any_of(scene.stars.begin(), scene.stars.end(),
                                        [](const Star &star) { return star.spectrum.kind != Spectrum::Kind::lines; });
    if (continuous && !scene.band)
        reader.refuse(Status::scene, "band", ": is missing: required unless all spectra are lines");
    if (!continuous && scene.band)
        reader.refuse(Status::scene, "band", ": not allowed: all spectra are lines");
    if (scene.stars.size() == 2 && !reader.has("binary"))
        reader.refuse(Status::scene, "binary", ": is missing: two stars need their positions");
    if (scene.stars.size() == 1 && reader.has_object("binary") && !reader.object("binary").has("offsets_px"))
        reader.refuse(Status::scene, "binary", ": a single star allows offsets_px only");
}

void check_observer(const Reader &reader, const Scene &scene) {
    if (scene.binary.sky == nullptr)
        return;
    if (!scene.binary.moving)
        reader.refuse(Status::scene, "binary.observer", ": needs binary.moving");
    if (!(scene.binary.date >= kFirstDate && scene.binary.date <= kLastDate))
        reader.refuse(Status::scene, "binary.date", " = %g: must be in [%g, %g] with an observer", scene.binary.date,
                      kFirstDate, kLastDate);
}

void derive_positions(const Reader &reader, Scene &scene) {
    Binary &binary = scene.binary;
    if (!binary.orbit)
        return;
    check_observer(reader, scene);
    const sky::OrbitPosition position = sky::position_on_orbit(*binary.orbit, binary.date);
    binary.separation_arcsec = position.separation_arcsec();
    binary.position_angle_deg = position.position_angle_deg();
    if (binary.separation_arcsec == 0)
        reader.refuse(Status::scene, "binary.orbit",
                      ": both stars are at the same position: the separation has no direction");
}

void check_fluxes(const Reader &reader, const Scene &scene) {
    const auto with = [&](bool (*has)(const Star &)) {
        return static_cast<size_t>(std::count_if(scene.stars.begin(), scene.stars.end(), has));
    };
    const size_t stars = scene.stars.size(),
                 known = with([](const Star &star) { return star.photons_per_s || !star.magnitude_band.empty(); }),
                 detected = with([](const Star &star) { return star.detected; });
    if (known != stars && scene.cadence.exposure_s > 0)
        reader.refuse(Status::scene, "cadence.exposure_s",
                      ": needs photons_per_s, detected_per_s or magnitude for every star");
    if (known != stars && known > 0)
        reader.refuse(Status::scene, "stars",
                      ": give photons_per_s, detected_per_s or magnitude for both stars or neither");
    if (detected != stars && detected > 0)
        reader.refuse(Status::scene, "stars", ": give detected_per_s for both stars or neither");
}

void derive_signal(const Reader &reader, Scene &scene) {
    Signal &signal = scene.signal;
    if (signal.kind != Signal::Kind::planet)
        return;
    const char star = signal.star == 0 ? 'A' : 'B';
    const std::optional<double> &mass_sun = scene.stars[signal.star].mass_sun, &distance_pc = scene.binary.distance_pc;
    if (!mass_sun)
        reader.refuse(Status::scene, "signal.kind", " = \"planet\": needs stars.%c.mass_sun", star);
    if (!distance_pc)
        reader.refuse(Status::scene, "signal.kind", " = \"planet\": needs binary.distance_pc");
    const Planet planet = {signal.mass_earth, signal.semi_major_au, *mass_sun, *distance_pc};
    signal.amplitude_px = reflex_uas(planet) / (1e6 * scene.detector.pixel_scale_arcsec) * pixels_along_axis(scene);
    signal.period_days = period_days(planet);
    const double farthest = signal.amplitude_px * (1 + signal.eccentricity);
    if (farthest > kFarthestDisplacement)
        reader.refuse(Status::scene, "signal.mass_earth",
                      " = %g: moves star %c by up to %.3g px: must be at most %g px", planet.mass_earth, star, farthest,
                      kFarthestDisplacement);
}

constexpr Row kNoiseRows[] = {
    optional<&Noise::photon>("photon", "Poisson noise of the photons"),
    optional<&Noise::read_e>("read_e", within(0, 1e6, "e-"), "Read noise, rms per pixel"),
    optional<&Noise::seed>("seed", within(0, kLargestWhole), "Seed"),
};
constexpr Group kNoise = group_of("noise", "Noise", kNoiseRows);

void read_projected(const Reader &reader, const Row &row, Scene &scene) {
    const std::vector<std::string> words = split(row.words);
    for (const std::string &name : reader.texts(row)) {
        if (std::find(words.begin(), words.end(), name) == words.end())
            reader.refuse(Status::scene, row.key, ": \"%.40s\": must be one of %s", name.c_str(),
                          join(words, "\"", ", ").c_str());
        const Parameter parameter = *parameter_named(name);
        if (parameter.kind == Parameter::Kind::flux_b && scene.stars.size() < 2)
            reader.refuse(Status::scene, row.key, ": \"flux_b\": the scene has star A only");
        if (std::count(scene.projected.begin(), scene.projected.end(), parameter) != 0)
            reader.refuse(Status::scene, row.key, ": duplicate \"%s\"", name.c_str());
        scene.projected.push_back(parameter);
    }
    const auto given = [&](Parameter::Kind kind) {
        return std::count(scene.projected.begin(), scene.projected.end(), Parameter{kind}) != 0;
    };
    if (given(Parameter::Kind::roll) && given(Parameter::Kind::position_angle))
        reader.refuse(Status::scene, row.key, ": \"roll\" and \"position_angle\" differ by a shift: give one of them");
}

constexpr Row kPreprocessRows[] = {
    optional<read_projected>("project", Words{kProjectable},
                             "Nuisance parameters that are projected out, so that estimators are insensitive to them")
        .as(Type::words)
        .entries(0, kMaxProjected),
};
constexpr Group kPreprocess = group_of("preprocess", "Preprocessing of a frame by all estimators", kPreprocessRows);

// In this order, because groups use those before them.
constexpr Row kSceneRows[] = {
    required<check_word<Scene>>("schema", Words{"toliman-scene/1"}, "Schema of the file"),
    optional<read_scene_name>("name", "Name of the scene, default name of the results folder").as(Type::name),
    required<&Scene::telescope>("telescope", &kTelescope),
    optional<&Scene::band>("band", &kBand),
    required<&Scene::stars>("stars", &kStars).checked<check_stars>(),
    optional<&Scene::binary>("binary", &kBinary).checked<derive_positions>(),
    required<&Scene::cadence>("cadence", &kCadence).checked<check_fluxes>(),
    required<&Scene::detector>("detector", &kDetector),
    optional<&Scene::signal>("signal", &kSignal).checked<derive_signal>(),
    optional<&Scene::noise>("noise", &kNoise),
    optional<&Scene::systematics>("systematics", &kSystematics),
    part("preprocess", &kPreprocess),
    optional<&Scene::accuracy>("accuracy", within(1e-15, 1),
                               "Allowed relative error of the noise-free frame and of the signal"),
    part("calibration", &kCalibration).checked<note_calibration>(),
};

} // namespace

constexpr Group kScene =
    group_of("scene",
             "A scene of the TOLIMAN simulator: telescope, stars, signal, cadence, detector and noise. Key names "
             "contain the units. A missing key switches its stage off; an unknown key is an error. File names are "
             "relative to the scene file. The text is at most 256 KiB, 16 levels deep and 4096 values long",
             kSceneRows);

} // namespace toliman::scene

namespace toliman {

double longest_days(const Cadence &cadence) noexcept {
    double longest = cadence.interval_days * static_cast<double>(cadence.frames - 1);
    if (!cadence.times_days.empty())
        longest = 0;
    for (const double days : cadence.times_days)
        longest = std::max(longest, std::fabs(days));
    return longest;
}

double time_days(const Cadence &cadence, int64_t k) noexcept {
    if (cadence.times_days.empty())
        return static_cast<double>(k) * cadence.interval_days;
    return cadence.times_days[std::min(static_cast<size_t>(k), cadence.times_days.size() - 1)];
}

double on_target_s(const Cadence &cadence) noexcept {
    if (!cadence.windows.empty())
        return cadence.windows_s;
    double total = cadence.on_target_s.empty() ? cadence.exposure_s : 0;
    for (size_t i = 0; i + 1 < cadence.on_target_s.size(); i += 2)
        total += cadence.on_target_s[i + 1] - cadence.on_target_s[i];
    return total;
}

int64_t tai_of_date(double date) noexcept {
    const double days = (date - 2000) * sky::kDaysPerYear, whole = std::floor(days);
    return static_cast<int64_t>(whole) * sky::kNsPerDay +
           std::llround((days - whole) * static_cast<double>(sky::kNsPerDay)) + sky::kJ2000Ns - sky::kTtMinusTaiNs;
}

int64_t time_zero_ns(const Binary &binary) noexcept {
    constexpr double kFirst = 1700, kLast = 2250;
    return binary.moving && binary.date >= kFirst && binary.date <= kLast ? tai_of_date(binary.date) : 0;
}

std::vector<sky::Interval> whole_exposure_at(const Cadence &cadence, int64_t zero_ns, double days) {
    const int64_t middle = zero_ns + std::llround(days * static_cast<double>(sky::kNsPerDay)),
                  half = std::llround(cadence.exposure_s * 5e8);
    return {{middle - half, middle + half}};
}

std::vector<sky::Interval> exposure_at(const Cadence &cadence, int64_t zero_ns, double days) {
    if (!(cadence.exposure_s > 0))
        return {};
    const std::vector<sky::Interval> all = whole_exposure_at(cadence, zero_ns, days);
    const auto [start_ns, end_ns] = all.front();
    const auto from_start = [start = start_ns](double seconds) { return start + std::llround(seconds * 1e9); };
    std::vector<sky::Interval> parts;
    for (size_t i = 0; i + 1 < cadence.on_target_s.size(); i += 2)
        parts.push_back({from_start(cadence.on_target_s[i]), from_start(cadence.on_target_s[i + 1])});
    auto window = std::partition_point(cadence.windows.begin(), cadence.windows.end(),
                                       [start = start_ns](const sky::Interval &one) { return one.end_ns <= start; });
    for (; window != cadence.windows.end() && window->start_ns < end_ns; ++window)
        parts.push_back({std::max(window->start_ns, start_ns), std::min(window->end_ns, end_ns)});
    return parts.empty() && cadence.windows.empty() ? all : parts;
}

double seconds_of(const std::vector<sky::Interval> &intervals) noexcept {
    double seconds = 0;
    for (const sky::Interval &interval : intervals)
        seconds += static_cast<double>(interval.end_ns - interval.start_ns) * 1e-9;
    return seconds;
}

std::string with_bad_pixels(const std::string &json, const std::string &source, const std::string &path) {
    json::Value tree = json::parse(json, source);
    if (tree.find("detector") != nullptr && tree.member("detector").kind == json::Value::Kind::object)
        tree.member("detector").member("bad_pixels") = json::Value::of(std::filesystem::absolute(path).string());
    return json::print(tree);
}

Scene read_scene(const std::string &json, const std::string &source, const std::string &folder) {
    const json::Value tree = json::parse(json, source);
    Scene scene;
    scene.source = source;
    scene.digest = fnv1a(json.data(), json.size());
    scene.json = json;
    scene.folder = folder;
    const scene::Context context = {source, folder, scene};
    read_group(scene::kScene, scene::Reader(tree, "", context), &scene);
    return scene;
}

} // namespace toliman
