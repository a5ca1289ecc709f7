// toliman pupil: designs a phase mask for a scene.
#include <filesystem>
#include <iterator>
#include <sstream>

#include "common/npy.hpp"
#include "options/command.hpp"
#include "scenes/scene.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

struct PupilOptions {
    std::string scene, out, symmetry = "none";
    std::optional<std::string> free;
    std::vector<double> dates, angles;
    toliman_mask_options design = toliman::sized<toliman_mask_options>();
    bool as_json = false;
};

constexpr char kEight[] = "flux_a,flux_b,shift_x,shift_y,roll,scale,focus,background";
constexpr char kEightOfOne[] = "flux_a,shift_x,shift_y,roll,scale,focus,background";

// The design and what it was made for.
struct Design {
    const Scene &scene;
    const PupilOptions &options;
    std::string free; // names, separated by commas
    std::vector<toliman_mask_info> places;
    std::vector<double> descent;
    std::vector<uint8_t> cells; // [pupil_samples][pupil_samples]
    std::string mask;           // JSON
};

toliman::phase_mask design_of(const Scene &scene, const PupilOptions &options, const std::string &free,
                              Progress &progress) {
    toliman_mask_options design = options.design;
    design.free = free.c_str();
    design.dates = options.dates.data();
    design.date_count = options.dates.size();
    design.position_angles_deg = options.angles.data();
    design.position_angle_count = options.angles.size();
    design.symmetry = options.symmetry == "even"  ? TOLIMAN_MASK_SYMMETRY_EVEN
                      : options.symmetry == "odd" ? TOLIMAN_MASK_SYMMETRY_ODD
                                                  : TOLIMAN_MASK_SYMMETRY_NONE;
    design.progress = Progress::callback;
    design.progress_data = &progress;
    try {
        return toliman::make<toliman::phase_mask>(toliman_mask_create, scene.sim.get(), &design);
    } catch (const toliman::error &error) {
        refuse_option(error, {{"free", "--free"},
                              {"dates", "--dates"},
                              {"position_angles_deg", "--position-angles"},
                              {"peak_to_mean", "--peak-to-mean"},
                              {"light_in_frame", "--light"}});
        throw;
    }
}

Design result_of(const Scene &scene, const PupilOptions &options, Progress &progress) {
    const std::string eight = scene.info.flux_ratio > 0 ? kEight : kEightOfOne;
    Design design = {scene, options, options.free.value_or(eight), {}, {}, {}, ""};
    const toliman::phase_mask mask = design_of(scene, options, design.free, progress);
    const size_t places = std::max({size_t{1}, options.dates.size(), options.angles.size()});
    const toliman_mask *const made = mask.get();
    design.places = items_of(toliman_mask_get_place, made, static_cast<int64_t>(places));
    design.descent.resize(design.places[0].iterations);
    toliman::check(toliman_mask_get_descent(mask.get(), design.descent.size(), design.descent.data()));
    const auto side = static_cast<size_t>(scene.info.pupil_samples);
    std::vector<double> cells(side * side);
    toliman::check(toliman_mask_get_cells(mask.get(), side, cells.data()));
    design.cells.assign(cells.begin(), cells.end());
    design.mask = toliman_mask_get_json(mask.get());
    return design;
}

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

// The scene with the mask, for this folder.
std::string scene_with(const Design &design, const std::string &folder) {
    const JsonTree tree = read_scene_json(design.scene.path);
    move_files(tree.get(), folder_of(design.scene.path), folder);
    cJSON *telescope = item_of(tree.get(), "telescope");
    cJSON_DeleteItemFromObjectCaseSensitive(telescope, "mask");
    cJSON_AddItemToObject(telescope, "mask", cJSON_Parse(design.mask.c_str()));
    return text_of(tree);
}

// One score of the scene's mask and of the designed one, and its quantum bound, if it has one.
struct Pair {
    const char *name, *title;
    double toliman_mask_info::*before, toliman_mask_info::*after, toliman_mask_info::*quantum = nullptr;
};
constexpr Pair kScores[] = {
    {"crb_alone_px", "alone", &toliman_mask_info::crb_alone_before_px, &toliman_mask_info::crb_alone_px,
     &toliman_mask_info::quantum_px},
    {"crb_flux_shift_px", "fluxes, shift", &toliman_mask_info::crb_flux_shift_before_px,
     &toliman_mask_info::crb_flux_shift_px, &toliman_mask_info::quantum_flux_shift_px},
    {"crb_px", "all free", &toliman_mask_info::crb_before_px, &toliman_mask_info::crb_px},
    {"peak_to_mean", "peak-to-mean", &toliman_mask_info::peak_to_mean_before, &toliman_mask_info::peak_to_mean},
    {"light_in_frame", "light", &toliman_mask_info::light_in_frame_before, &toliman_mask_info::light_in_frame},
    {"gradient_energy", "gradient", &toliman_mask_info::gradient_energy_before, &toliman_mask_info::gradient_energy},
    {"radius_50_px", "r50, px", &toliman_mask_info::radius_50_before_px, &toliman_mask_info::radius_50_px},
    {"radius_80_px", "r80, px", &toliman_mask_info::radius_80_before_px, &toliman_mask_info::radius_80_px},
};

// The words of a list that spaces or commas separate.
std::vector<std::string> names_in(std::string list) {
    std::replace(list.begin(), list.end(), ',', ' ');
    std::istringstream words(list);
    return {std::istream_iterator<std::string>(words), {}};
}

std::optional<double> listed(const std::vector<double> &values, size_t place) {
    return values.empty() ? std::nullopt : std::optional(values[place]);
}

Json place_json(const Design &design, size_t place) {
    const toliman_mask_info &info = design.places[place];
    Json own, designed;
    for (const Pair &score : kScores) {
        own.set(score.name, info.*score.before);
        designed.set(score.name, info.*score.after);
    }
    return Json("date", listed(design.options.dates, place), "position_angle_deg", listed(design.options.angles, place),
                "quantum_px", info.quantum_px, "quantum_flux_shift_px", info.quantum_flux_shift_px, "scene_mask", own,
                "designed", designed);
}

std::string as_json(const Design &design) {
    const toliman_mask_info &info = design.places[0];
    Json json("schema", "toliman-pupil/1", "version", toliman_version(), "scene", design.scene.info.name, "seed",
              design.options.design.seed, "free", names_in(design.free), "improved", info.improved != 0, "stopped",
              info.stopped != 0, "iterations", info.iterations, "small_features", info.small_features);
    std::vector<Json> places;
    for (size_t place = 0; place < design.places.size(); place++)
        places.push_back(place_json(design, place));
    json.set("places", places, "mask", JsonTree(cJSON_Parse(design.mask.c_str())), "descent_px", design.descent);
    return json.text();
}

void write_folder(OutputFolder &out, const Design &design) {
    const auto side = static_cast<size_t>(design.scene.info.pupil_samples);
    write_npy(out.open("mask.npy"), design.cells, {side, side});
    out.open("scene.json", Replaces::scenes).write(scene_with(design, design.options.out));
    out.open("pupil.json").write(as_json(design));
    out.commit("pupil.json");
}

std::string place_text(const PupilOptions &options, size_t place) {
    return !options.dates.empty()    ? formatted("date %g", options.dates[place])
           : !options.angles.empty() ? formatted("%g deg", options.angles[place])
                                     : "scene";
}

void print_summary(const Design &design) {
    const toliman_mask_info &first = design.places[0];
    std::printf("scene          %s\n", design.scene.info.name);
    std::printf("free           %s\n", design.free.empty() ? "none" : design.free.c_str());
    for (size_t place = 0; place < design.places.size(); place++) {
        const toliman_mask_info &info = design.places[place];
        std::printf("\n%-14s %12s %12s %12s\n", place_text(design.options, place).c_str(), "scene's mask", "designed",
                    "quantum");
        for (const Pair &score : kScores) {
            const bool has_quantum = score.quantum != nullptr && std::isfinite(info.*score.quantum);
            std::printf("%-14s %12.4g %12.4g %12s\n", score.title, info.*score.before, info.*score.after,
                        has_quantum ? formatted("%.4g", info.*score.quantum).c_str() : "");
        }
    }
    std::printf("\niterations     %llu\n", static_cast<unsigned long long>(first.iterations));
    std::printf("small features %.2g of the open cells\n", first.small_features);
    print_stdout(first.improved != 0 ? ""
                                     : "result         not better than the scene's mask at every place, or above the "
                                       "limit of the peak: try another --seed or more --iterations\n");
}

void pupil(const PupilOptions &options, Progress &progress) {
    std::optional<OutputFolder> out;
    if (!options.out.empty()) {
        const std::vector<const char *> files = {"mask.npy", "pupil.json"};
        out.emplace(options.out, files).open("scene.json", Replaces::scenes);
    }
    const Scene scene(options.scene, progress);
    const Design design = result_of(scene, options, progress);
    progress.clear();
    if (out)
        write_folder(*out, design);
    if (options.as_json)
        print_stdout(as_json(design));
    else
        print_summary(design);
    stop_if_asked();
}

CLI::Option *add_list(CLI::App *command, const char *name, std::vector<double> &values, const char *type) {
    return add_option(command, name, values, type)->delimiter(',')->allow_extra_args(false);
}

} // namespace

void add_pupil(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "pupil");
    auto options = std::make_shared<PupilOptions>();
    toliman_mask_options &design = options->design;
    add_scene(*command, options->scene);
    add_option(command, "--out", options->out, "FOLDER");
    add_option(command, "--free", options->free, "NAMES");
    CLI::Option *dates = add_list(command, "--dates", options->dates, "YEAR,...");
    add_list(command, "--position-angles", options->angles, "DEG,...")->excludes(dates);
    add_option(command, "--peak-to-mean", design.peak_to_mean, "RATIO")->check(CLI::Range(1.000001, 1e12));
    add_option(command, "--light", design.light_in_frame, "SHARE")->check(CLI::Range(0.001, 0.999));
    add_option(command, "--feature", design.feature_cells, "CELLS")->check(CLI::Range(1u, 16u));
    add_choice(command, "--symmetry", options->symmetry, {"none", "even", "odd"});
    add_option(command, "--iterations", design.iterations, "N")->check(CLI::Range(1u, 100000u));
    design.seed = 1;
    add_seed(*command, design.seed);
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, pupil);
}

} // namespace cli
