// include/toliman/budget.h
#include <toliman/budget.h>

#include "api/common.hpp"
#include "api/handles.hpp"
#include "api/parameters.hpp"
#include "information/budget.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

constexpr double kTenth = 0.1;

// The free parameters of the options, in the order of their names.
std::vector<Parameter> free_of(const optics::Simulator &simulator, const char *names) {
    if (names == nullptr)
        return simulator.scene().projected;
    std::vector<Parameter> free = parameters_of(names, "options->free_names");
    for (const Parameter parameter : free) {
        if (parameter.kind == Parameter::Kind::separation)
            fail(Status::argument, "{options->free_names}: separation: must not be in the list: it is always free");
        optics::check_parameter(simulator.scene(), simulator.plan(), parameter);
    }
    return free;
}

// The options, checked, for one simulator.
struct Request {
    std::vector<Parameter> free;
    std::vector<Parameter> others;
    double frames;
    information::Earth earth;
};

Request request_of(const optics::Simulator &simulator, const toliman_sim_budget_options *options) {
    const auto known = accept(options, "options");
    const information::Earth earth = known.earth_px > 0 ? information::Earth{known.earth_px, "the options"}
                                                        : information::earth_of(simulator.scene());
    const std::vector<Parameter> free = free_of(simulator, known.free_names);
    const bool low_orders = (known.flags & TOLIMAN_SIM_BUDGET_LOW_ORDERS) != 0;
    return {free, information::others_than(simulator, free, low_orders), static_cast<double>(known.frames), earth};
}

// Row i of the budget.
toliman_sim_budget_row public_row(const information::BudgetRow &row, size_t i, const information::BudgetFit &fit,
                                  double earth_px, double tenth_px) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    toliman_sim_budget_row result = {};
    result.is_free = row.free ? 1 : 0;
    result.name = public_parameter(row.parameter).name;
    result.unit = unit_of(row.parameter);
    TOLIMAN_COPY(result, row, bias_px, curvature_px);
    result.earth_amount = row.amount(earth_px);
    result.tenth_crb_amount = row.amount(tenth_px);
    result.deviation = row.free ? fit.deviation[i] : unknown;
    result.correlation = row.free ? fit.correlations[i + 1] : unknown;
    return result;
}

} // namespace

extern "C" {

toliman_status toliman_sim_get_budget(const toliman_sim *sim, const toliman_sim_budget_options *options,
                                      toliman_sim_budget *out) noexcept {
    return query(sim, "sim", out, [&](auto &self, auto &budget) {
        const optics::Simulator &simulator = self.simulator;
        const Request request = request_of(simulator, options);
        const information::BoundOfFrames bound = information::bound_of_frames(simulator, request.free, request.frames);
        budget.crb_px = bound.one;
        budget.crb_shared_px = bound.shared;
        budget.uas_per_px = information::uas_per_px(simulator.scene());
        budget.earth_px = request.earth.px;
        budget.earth_from = request.earth.from;
        budget.free_count = request.free.size();
        budget.steps = information::budget_steps(simulator).size();
        budget.rows = request.free.size() + request.others.size() + 1; // flat
    });
}

toliman_status toliman_sim_get_budget_steps(const toliman_sim *sim, const toliman_sim_budget_options *options,
                                            toliman_sim_budget_step *steps, size_t capacity, size_t *count) noexcept {
    return call(sim, "sim", [&](auto &self) {
        const optics::Simulator &simulator = self.simulator;
        const Request request = request_of(simulator, options);
        const StructOutput<toliman_sim_budget_step> results(steps, "steps", capacity, count);
        std::vector<toliman_sim_budget_step> found;
        for (const information::BudgetStep &step : information::budget_steps(simulator)) {
            const information::BoundOfFrames bound = information::bound_of_frames(simulator, step.free, request.frames);
            found.push_back({0, 0, step.name, bound.one, bound.shared});
        }
        results.write(found.size(), "steps", [&](size_t i) { return found[i]; });
    });
}

toliman_status toliman_sim_get_budget_rows(const toliman_sim *sim, const toliman_sim_budget_options *options,
                                           double *correlations, size_t side, toliman_sim_budget_row *rows,
                                           size_t capacity, size_t *count) noexcept {
    return call(sim, "sim", [&](auto &self) {
        const optics::Simulator &simulator = self.simulator;
        const Request request = request_of(simulator, options);
        if (correlations != nullptr && side != request.free.size() + 1)
            fail(Status::argument, "{side} = %zu: must be %zu, the separation and the free parameters", side,
                 request.free.size() + 1);
        const StructOutput<toliman_sim_budget_row> results(rows, "rows", capacity, count);
        const information::BudgetFit fit = information::fit_of(simulator.images(), request.free);
        const double tenth_px = kTenth * information::bound_with(simulator.images(), request.free);
        const std::vector<information::BudgetRow> found =
            information::budget_rows(simulator, request.free, request.others, fit);
        results.write(found.size(), "rows",
                      [&](size_t i) { return public_row(found[i], i, fit, request.earth.px, tenth_px); });
        copy_to(correlations, fit.correlations);
    });
}

} // extern "C"
