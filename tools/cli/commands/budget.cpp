// toliman budget: which unknown parameters limit the separation, with the scene's mask and without.
#include "options/command.hpp"
#include "scenes/scene.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

struct BudgetOptions {
    std::string scene;
    std::optional<std::string> free;
    toliman_sim_budget_options budget = toliman::sized<toliman_sim_budget_options>();
    bool without_mask = false, all = false, as_json = false;
};

// Called with the fraction done; throws if a signal has arrived.
using Advance = std::function<void(double fraction)>;

constexpr double kNotable = 0.3; // correlation

struct Correlation {
    std::string a, b;
    double value;
};

struct Budget {
    toliman_sim_budget summary;
    std::vector<toliman_sim_budget_step> steps;
    std::vector<toliman_sim_budget_row> rows;
    std::vector<Correlation> correlations; // those above kNotable
};

Budget budget_of(const Scene &scene, const toliman_sim_budget_options &options, const Advance &advance) {
    const StopLimit limit;
    advance(0);
    Budget budget = {toliman::sized<toliman_sim_budget>(), {}, {}, {}};
    try {
        toliman::check(toliman_sim_get_budget(scene.sim.get(), &options, &budget.summary));
    } catch (const toliman::error &error) {
        refuse_option(error, {{"free_names", "--free"}});
        throw;
    }
    advance(0.1);
    size_t count = 0;
    budget.steps.assign(budget.summary.steps, toliman::sized<toliman_sim_budget_step>());
    toliman::check(
        toliman_sim_get_budget_steps(scene.sim.get(), &options, budget.steps.data(), budget.steps.size(), &count));
    advance(0.3);
    const size_t n = budget.summary.free_count + 1;
    std::vector<double> matrix(n * n);
    budget.rows.assign(budget.summary.rows, toliman::sized<toliman_sim_budget_row>());
    toliman::check(toliman_sim_get_budget_rows(scene.sim.get(), &options, matrix.data(), n, budget.rows.data(),
                                               budget.rows.size(), &count));
    const auto name = [&](size_t i) { return i == 0 ? "separation" : budget.rows[i - 1].name; };
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n; j++)
            if (std::fabs(matrix[i * n + j]) > kNotable)
                budget.correlations.push_back({name(i), name(j), matrix[i * n + j]});
    return budget;
}

// The scene with a clear pupil.
Budget budget_without_mask(const Scene &scene, const toliman_sim_budget_options &options, const Advance &advance) {
    const StopLimit limit;
    const JsonTree tree = read_scene_json(scene.path);
    merge(tree.get(), R"({"telescope": {"mask": null}})");
    return budget_of({scene.path, text_of(tree)}, options, advance);
}

Json json_of(const Budget &budget) {
    const auto &summary = budget.summary;
    Json json("crb_px", summary.crb_px, "crb_shared_px", summary.crb_shared_px);
    json.set("steps", array_of(budget.steps, [](const auto &step) {
                 return Json("name", step.name, "crb_px", step.crb_px, "crb_shared_px", step.crb_shared_px);
             }));
    json.set("parameters", array_of(budget.rows, [](const auto &row) {
                 return Json("name", row.name, "unit", row.unit, "free", row.is_free != 0, "bias_px", row.bias_px,
                             "curvature_px", row.curvature_px, "earth_amount", row.earth_amount, "tenth_crb_amount",
                             row.tenth_crb_amount, "deviation", row.deviation, "correlation", row.correlation);
             }));
    json.set("correlations", array_of(budget.correlations, [](const Correlation &pair) {
                 return Json("a", pair.a, "b", pair.b, "correlation", pair.value);
             }));
    return json;
}

void print_json(const BudgetOptions &options, const Budget &with, const std::optional<Budget> &without) {
    const auto &summary = with.summary;
    const int64_t frames = std::max<int64_t>(options.budget.frames, 1);
    print_stdout(Json("schema", "toliman-budget/1", "version", toliman_version(), "scene", options.scene, "frames",
                      frames, "uas_per_px", summary.uas_per_px, "earth_px", summary.earth_px, "earth_from",
                      summary.earth_from, "scene_mask", json_of(with), "without_mask",
                      without ? std::optional(json_of(*without)) : std::nullopt)
                     .text());
}

std::string amount_text(double amount, const char *unit) {
    if (std::isnan(amount))
        return "not known";
    return std::isinf(amount) ? "none" : formatted("%.2g", amount) + (*unit != '\0' ? std::string(" ") + unit : "");
}

std::string number_text(double value) {
    return std::isnan(value) ? "-" : formatted("%.2e", value);
}

void print_head(const BudgetOptions &options, const Budget &budget) {
    const auto &summary = budget.summary;
    std::vector<std::string> free;
    for (size_t i = 0; i < summary.free_count; i++)
        free.emplace_back(budget.rows[i].name);
    std::printf("scene      %s\n", options.scene.c_str());
    std::printf("an Earth   %s px = %s uas: %s\n", number_text(summary.earth_px).c_str(),
                amount_text(summary.earth_px * summary.uas_per_px, "").c_str(), summary.earth_from);
    std::printf("free       %s\n", free.empty() ? "none" : joined(free, " ").c_str());
    std::printf("bound      %.3e px = %.3g uas = %s Earths per frame\n", summary.crb_px,
                summary.crb_px * summary.uas_per_px, amount_text(summary.crb_px / summary.earth_px, "").c_str());
}

void print_steps(const BudgetOptions &options, const Budget &with, const std::optional<Budget> &without) {
    const bool shared = options.budget.frames > 1;
    std::printf("\n%-22s %10s %8s %8s", "bounds per frame, free", "px", "uas", "Earths");
    if (shared)
        std::printf(" %12s", formatted("px, K = %lld", static_cast<long long>(options.budget.frames)).c_str());
    std::printf("%s\n", without ? "  px without mask" : "");
    const auto &summary = with.summary;
    for (size_t i = 0; i < with.steps.size(); i++) {
        const auto &step = with.steps[i];
        std::printf("%-22s %10.3e %8.3g %8s", step.name, step.crb_px, step.crb_px * summary.uas_per_px,
                    amount_text(step.crb_px / summary.earth_px, "").c_str());
        if (shared)
            std::printf(" %12.3e", step.crb_shared_px);
        if (without)
            std::printf("  %15.3e", without->steps[i].crb_px);
        std::printf("\n");
    }
}

// The row of the same parameter, if that budget has it.
const toliman_sim_budget_row *row_of(const std::optional<Budget> &budget, const char *name) {
    if (!budget)
        return nullptr;
    const auto found = std::find_if(budget->rows.begin(), budget->rows.end(),
                                    [&](const auto &row) { return std::strcmp(row.name, name) == 0; });
    return found != budget->rows.end() ? &*found : nullptr;
}

// Free or fixed parameters: effect per unit, and the amounts with the effect of an Earth and of a tenth of the bound.
void print_rows(const BudgetOptions &options, const Budget &with, const std::optional<Budget> &without, bool free) {
    std::printf("\n%-14s %12s %14s %14s%s%s\n", free ? "fitted" : "not fitted", free ? "px per unit^2" : "px per unit",
                "an Earth", "0.1 sigma", free ? "         fit's sigma" : "", without ? "  Earth without mask" : "");
    for (const auto &row : with.rows) {
        if ((row.is_free != 0) != free)
            continue;
        std::printf("%-14s %12s %14s %14s", row.name, number_text(free ? row.curvature_px : row.bias_px).c_str(),
                    amount_text(row.earth_amount, row.unit).c_str(),
                    amount_text(row.tenth_crb_amount, row.unit).c_str());
        if (free)
            std::printf(" %19s", amount_text(row.deviation, row.unit).c_str());
        if (without) {
            const auto *const other = row_of(without, row.name);
            std::printf(" %19s", other != nullptr ? amount_text(other->earth_amount, other->unit).c_str() : "-");
        }
        std::printf("\n");
    }
    if (!free && (options.budget.flags & TOLIMAN_SIM_BUDGET_LOW_ORDERS) != 0)
        std::printf("Zernike polynomials above 11 and spectral modes above 2: --all\n");
}

void print_correlations(const Budget &budget) {
    if (budget.correlations.empty())
        return;
    std::printf("\ncorrelations above %.1f in the fit\n", kNotable);
    for (const Correlation &pair : budget.correlations)
        std::printf("%-14s %-14s %6.3f\n", pair.a.c_str(), pair.b.c_str(), pair.value);
}

void budget(BudgetOptions &options, Progress &progress) {
    if (options.free)
        options.budget.free_names = options.free->c_str();
    if (!options.all && !options.as_json)
        options.budget.flags = TOLIMAN_SIM_BUDGET_LOW_ORDERS;
    const Scene scene(options.scene, progress);
    const auto advance = [&](const char *stage) {
        return [&progress, stage](double fraction) {
            stop_if_asked();
            progress.show(stage, fraction);
        };
    };
    const Budget with = budget_of(scene, options.budget, advance("budget"));
    std::optional<Budget> without;
    if (options.without_mask)
        without = budget_without_mask(scene, options.budget, advance("without mask"));
    if (options.as_json)
        return print_json(options, with, without);
    print_head(options, with);
    print_steps(options, with, without);
    print_rows(options, with, without, false);
    if (with.summary.free_count > 0)
        print_rows(options, with, without, true);
    print_correlations(with);
    print_stdout("");
}

} // namespace

void add_budget(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "budget");
    auto options = std::make_shared<BudgetOptions>();
    add_scene(*command, options->scene);
    add_option(command, "--free", options->free, "NAMES");
    add_option(command, "--frames", options->budget.frames, "K")->check(CLI::Range(int64_t{1}, int64_t{1000000000}));
    add_option(command, "--earth-px", options->budget.earth_px, "PX")->check(CLI::Range(1e-12, 100.0));
    command->add_flag("--without-mask", options->without_mask);
    command->add_flag("--all", options->all);
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, budget);
}

} // namespace cli
