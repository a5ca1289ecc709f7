#include "optics/scene.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/hash.hpp"
#include "base/name.hpp"
#include "optics/scene_groups.hpp"

namespace toliman::optics {

namespace {

constexpr double kLargestWhole = 9007199254740991.0; // JSON numbers are doubles: 2^53 + 1 would become 2^53

std::string read_name(const Reader &scene) {
    if (!scene.has("name"))
        return "";
    const std::string &name = scene.text("name");
    if (!is_name(name))
        scene.refuse(Status::scene, "name", " = \"%.40s\": %s", name.c_str(), kNameRule);
    return name;
}

Noise read_noise(const Reader &scene) {
    Noise noise;
    if (!scene.has("noise"))
        return noise;
    const Reader reader = scene.object("noise");
    reader.allow({"photon", "read_e", "seed"});
    noise.photon = reader.boolean_or("photon", false);
    noise.read_e = reader.number_or("read_e", 0, within(0, 1e6, "e-"));
    if (reader.has("seed"))
        noise.seed = static_cast<uint64_t>(reader.integer("seed", within(0, kLargestWhole, "")));
    return noise;
}

std::vector<Nuisance> read_projected(const Reader &scene, size_t stars) {
    std::vector<Nuisance> projected;
    if (!scene.has("preprocess"))
        return projected;
    const Reader reader = scene.object("preprocess");
    reader.allow({"project"});
    if (!reader.has("project"))
        return projected;
    for (const std::string &name : reader.texts("project")) {
        size_t found = 0;
        while (found < kNuisances && name != name_of(static_cast<Nuisance>(found)))
            found++;
        if (found == kNuisances)
            reader.refuse(Status::scene, "project",
                          ": \"%.40s\": must be one of \"flux_a\", \"flux_b\", \"shift_x\", \"shift_y\", "
                          "\"roll\", \"scale\", \"focus\", \"background\"",
                          name.c_str());
        const auto nuisance = static_cast<Nuisance>(found);
        if (nuisance == Nuisance::flux_b && stars < 2)
            reader.refuse(Status::scene, "project", ": \"flux_b\": the scene has star A only");
        if (std::count(projected.begin(), projected.end(), nuisance) != 0)
            reader.refuse(Status::scene, "project", ": duplicate \"%s\"", name.c_str());
        projected.push_back(nuisance);
    }
    return projected;
}

void check_band(const Reader &reader, const Scene &scene) {
    const bool continuous = std::any_of(scene.stars.begin(), scene.stars.end(),
                                        [](const Star &star) { return star.source.kind != Source::Kind::lines; });
    if (continuous && !scene.band)
        reader.refuse(Status::scene, "band", ": is missing: required unless all spectra are lines");
    if (!continuous && scene.band)
        reader.refuse(Status::scene, "band", ": not allowed: all spectra are lines");
}

} // namespace

const char *name_of(Nuisance nuisance) noexcept {
    constexpr const char *names[kNuisances] = {"flux_a", "flux_b", "shift_x", "shift_y",
                                               "roll",   "scale",  "focus",   "background"};
    return names[static_cast<size_t>(nuisance)];
}

double longest_days(const Cadence &cadence) noexcept {
    double longest = cadence.interval_days * static_cast<double>(cadence.frames - 1);
    if (!cadence.times_days.empty())
        longest = 0;
    for (const double days : cadence.times_days)
        longest = std::max(longest, std::fabs(days));
    return longest;
}

Scene read_scene(const std::string &json, const std::string &source, const std::string &folder) {
    const json::Value tree = json::parse(json, source);
    const Reader reader(tree, "", source);
    reader.allow({"schema", "name", "telescope", "band", "stars", "binary", "signal", "cadence", "detector", "noise",
                  "systematics", "preprocess", "accuracy"});
    reader.choice("schema", {"toliman-scene/1"});
    Scene scene;
    scene.source = source;
    scene.digest = fnv1a(json.data(), json.size());
    scene.name = read_name(reader);
    scene.telescope = read_telescope(reader, folder);
    scene.band = read_band(reader);
    scene.stars = read_stars(reader, folder);
    check_band(reader, scene);
    scene.binary = read_binary(reader, scene.stars.size());
    scene.cadence = read_cadence(reader, scene.stars, folder);
    scene.detector = read_detector(reader, scene.cadence);
    scene.signal = read_signal(reader, scene);
    scene.noise = read_noise(reader);
    scene.systematics = read_systematics(reader, scene.cadence);
    scene.projected = read_projected(reader, scene.stars.size());
    scene.accuracy = reader.number_or("accuracy", scene.accuracy, within(1e-15, 1, ""));
    return scene;
}

} // namespace toliman::optics
