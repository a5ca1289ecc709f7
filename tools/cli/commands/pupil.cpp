// toliman pupil: searches for a better phase mask for a scene.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "common/failure.hpp"
#include "common/json.hpp"
#include "common/output.hpp"
#include "options/command.hpp"
#include "scenes/pupil_search.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

struct Options {
    std::string scene, out;
    SearchLimits limits;
    bool as_json = false;
};

constexpr uint64_t kDefaultCount = 4000;
constexpr double kMostMinutes = 100000;

// Rewrites file names of the scene that are relative to one folder, relative to another one.
void move_files(cJSON *item, const std::filesystem::path &from, const std::filesystem::path &to) {
    for (cJSON *child = item->child; child != nullptr; child = child->next) {
        const std::string name = child->string != nullptr ? child->string : "";
        const bool is_file = name == "file" || (name.size() > 5 && name.substr(name.size() - 5) == "_file");
        if (is_file && cJSON_IsString(child) && child->valuestring[0] != '/')
            cJSON_SetValuestring(child, std::filesystem::proximate(from / child->valuestring, to).c_str());
        move_files(child, from, to);
    }
}

void write_scene(OutputFile &out, const std::string &path, const std::string &folder, const JsonTree &tree) {
    const std::filesystem::path to = std::filesystem::path(path).parent_path();
    move_files(tree.get(), folder, to.empty() ? "." : to);
    const std::string text = text_of(tree);
    out.write(text.data(), text.size());
    out.commit();
}

void print_json(const Scene &whole, const MaskedScene &scene, const Options &options, const Score &own,
                const Found &best, uint64_t tried) {
    Json json;
    json.set("schema", "toliman-pupil/1").set("version", toliman_version());
    json.set("scene", toliman_sim_get_name(whole.sim.get())).set("seed", options.limits.seed);
    json.set("judged", tried);
    json.set("crb_before_px", own.crb_px).set("crb_px", best.score.crb_px);
    json.set("peak_to_mean_before", own.peak_to_mean).set("peak_to_mean", best.score.peak_to_mean);
    json.set("light_in_frame_before", own.light_in_frame).set("light_in_frame", best.score.light_in_frame);
    if (!best.terms.empty())
        json.set("mask", scene.mask(best.terms));
    else
        json.set("mask",
                 JsonTree(scene.own_mask() != nullptr ? copy_of(scene.own_mask()).release() : cJSON_CreateNull()));
    print_stdout(json.text());
}

void print_line(const char *what, const Score &score) {
    std::printf("%-13s Cramer-Rao bound %.4g px, peak-to-mean %.2f, %.1f %% of the light in the frame\n", what,
                score.crb_px, score.peak_to_mean, 100 * score.light_in_frame);
}

void print_summary(const Scene &whole, const MaskedScene &scene, const Score &own, const Found &best, uint64_t tried) {
    std::printf("scene         %s: %llu masks tried\n", toliman_sim_get_name(whole.sim.get()),
                static_cast<unsigned long long>(tried));
    print_line("own mask", own);
    if (best.terms.empty()) {
        print_stdout("found         no better mask\n");
        return;
    }
    print_line("found", best.score);
    Json json;
    json.set("mask", scene.mask(best.terms));
    print_stdout(json.text());
}

void pupil(const Options &options, Progress &progress) {
    if (options.as_json && options.out == "-")
        throw Failure(kExitUsage, "--json with --out -: only one of them can go to standard output");
    std::optional<OutputFile> out;
    check_not_input(options.out, {options.scene});
    if (!options.out.empty())
        out.emplace(options.out, Replaces::scenes);
    const Scene whole(options.scene, progress);
    const MaskedScene scene(whole);
    const Score before = score_of(whole);
    if (!std::isfinite(before.crb_px))
        throw Failure(kExitUsage, options.scene + ": masks cannot be compared: the separation has no Cramer-Rao bound");
    PupilSearch search(scene, before, options.limits, progress);
    const Found best = search.run();
    progress.clear();
    if (out)
        write_scene(*out, options.out, folder_of(whole.path), scene.with(best.terms));
    if (options.as_json)
        print_json(whole, scene, options, before, best, search.tried());
    else if (options.out != "-")
        print_summary(whole, scene, before, best, search.tried());
    stop_if_asked();
}

} // namespace

void add_pupil(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "pupil");
    auto options = std::make_shared<Options>();
    add_scene(*command, options->scene);
    add_option(command, "--out", options->out, "FILE",
               "write the scene with the best mask to this file; - writes to standard output");
    CLI::Option *minutes =
        command->add_option("--minutes", options->limits.minutes, "time limit in minutes; default: none");
    CLI::Option *count =
        command
            ->add_option("--count", options->limits.count,
                         "largest number of masks to draw and vary; default 4000, with --minutes no limit")
            ->check(CLI::Range(1u, 1000000000u));
    add_seed(*command, options->limits.seed, "seed of the random masks, default 1");
    command->add_flag("--json", options->as_json, "print JSON, schema toliman-pupil/1");
    set_action(*command, context, options, pupil, [options, minutes, count] {
        if (minutes->count() > 0 && !(options->limits.minutes > 0 && options->limits.minutes <= kMostMinutes))
            throw CLI::ValidationError("--minutes", "must be above 0 and at most 100000");
        if (minutes->count() == 0 && count->count() == 0)
            options->limits.count = kDefaultCount;
    });
}

} // namespace cli
