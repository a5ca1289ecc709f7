// toliman pupil: searches for a better phase mask for a scene.
#include <cstdio>
#include <filesystem>
#include <optional>

#include "common/failure.hpp"
#include "common/json.hpp"
#include "common/library.hpp"
#include "common/output.hpp"
#include "common/stop.hpp"
#include "options/command.hpp"
#include "scenes/scene.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

struct Options {
    std::string scene, out;
    toliman_mask_options search = toliman::sized<toliman_mask_options>();
    bool as_json = false;
};

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
    out.write(text_of(tree));
    out.commit();
}

struct Result {
    const char *scene;
    toliman_mask_info info;
    JsonTree mask; // the best one; nullptr if the scene has none and no better one was found
};

void print_json(Result result, uint64_t seed) {
    const toliman_mask_info &info = result.info;
    print_stdout(Json("schema", "toliman-pupil/1", "version", toliman_version(), "scene", result.scene, "seed", seed,
                      "judged", info.tried, "crb_before_px", info.crb_before_px, "crb_px", info.crb_px,
                      "peak_to_mean_before", info.peak_to_mean_before, "peak_to_mean", info.peak_to_mean,
                      "light_in_frame_before", info.light_in_frame_before, "light_in_frame", info.light_in_frame,
                      "gradient_energy_before", info.gradient_energy_before, "gradient_energy", info.gradient_energy,
                      "mask", std::move(result.mask))
                     .text());
}

void print_line(const char *what, double crb_px, double peak_to_mean, double gradient_energy, double light_in_frame) {
    std::printf(
        "%-13s Cramer-Rao bound %.4g px, peak-to-mean %.2f, gradient energy %.3g px^-2, %.1f %% of the light in "
        "the frame\n",
        what, crb_px, peak_to_mean, gradient_energy, 100 * light_in_frame);
}

void print_summary(Result result) {
    const toliman_mask_info &info = result.info;
    std::printf("scene         %s: %llu masks tried\n", result.scene, static_cast<unsigned long long>(info.tried));
    print_line("own mask", info.crb_before_px, info.peak_to_mean_before, info.gradient_energy_before,
               info.light_in_frame_before);
    if (info.improved == 0) {
        print_stdout("found         no better mask\n");
        return;
    }
    print_line("found", info.crb_px, info.peak_to_mean, info.gradient_energy, info.light_in_frame);
    Json json;
    json.set("mask", std::move(result.mask));
    print_stdout(json.text());
}

void pupil(const Options &options, Progress &progress) {
    if (options.as_json && options.out == "-")
        throw Failure(kExitUsage, "--json with --out -: only one of them can go to standard output");
    std::optional<OutputFile> out;
    check_not_input(options.out, {options.scene});
    if (!options.out.empty())
        out.emplace(options.out, Replaces::scenes);
    const Scene scene(options.scene, progress);
    const JsonTree tree = read_scene_json(scene.path);
    toliman_mask_options search = options.search;
    search.progress = Progress::callback;
    search.progress_data = &progress;
    const auto found = toliman::make<toliman::phase_mask>(toliman_mask_search, scene.sim.get(), &search);
    progress.clear();
    const auto info = info_from<toliman_mask_info>(toliman_mask_get_info, found.get());
    cJSON *telescope = item_of(tree.get(), "telescope");
    if (info.improved != 0) {
        cJSON_DeleteItemFromObjectCaseSensitive(telescope, "mask");
        cJSON_AddItemToObject(telescope, "mask", cJSON_Parse(toliman_mask_get_json(found.get())));
    }
    Result result = {toliman_sim_get_name(scene.sim.get()), info, copy_of(item_of(telescope, "mask"))};
    if (out)
        write_scene(*out, options.out, folder_of(scene.path), tree);
    if (options.as_json)
        print_json(std::move(result), search.seed);
    else if (options.out != "-")
        print_summary(std::move(result));
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
        command->add_option("--minutes", options->search.minutes, "time limit in minutes; default: none");
    command
        ->add_option("--count", options->search.count,
                     "largest number of masks to draw and vary; default 4000, with --minutes no limit")
        ->check(CLI::Range(1u, 1000000000u));
    options->search.seed = 1;
    add_seed(*command, options->search.seed, "seed of the random masks, default 1");
    command->add_flag("--json", options->as_json, "print JSON, schema toliman-pupil/1");
    set_action(*command, context, options, pupil, [options, minutes] {
        if (minutes->count() > 0 && !(options->search.minutes > 0 && options->search.minutes <= kMostMinutes))
            throw CLI::ValidationError("--minutes", "must be above 0 and at most 100000");
    });
}

} // namespace cli
