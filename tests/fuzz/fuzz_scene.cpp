// Scenes: the plan has finite numbers, and scenes that are cheap are simulated to a finite frame.
#include <cmath>
// promise: parsers-are-safe

#include <toliman/toliman.hpp>

#include "fuzz.hpp"

using namespace fuzz;

namespace {

constexpr double kMostWork = 2e6; // flops to create it, so that most time is spent on reading
constexpr int64_t kMostPixels = 32 * 32;

void check(const toliman_sim_plan_info &plan) {
    for (const double number : {plan.setup_flops, plan.frame_flops, plan.setup_s, plan.frame_s})
        require(std::isfinite(number) && number >= 0, "an impossible plan");
    require(plan.wavelengths >= 1 && plan.bytes > 0, "an empty plan");
}

void make(const char *json, size_t size, const toliman_sim_options &options) {
    toliman_sim *sim = nullptr;
    if (toliman_sim_create_json(json, size, "nowhere", &options, &sim) != TOLIMAN_OK)
        return;
    auto info = toliman::sized<toliman_sim_info>();
    require(toliman_sim_get_info(sim, &info) == TOLIMAN_OK, toliman_last_error());
    if (info.rows * info.cols <= kMostPixels) {
        std::vector<double> frame(static_cast<size_t>(info.rows * info.cols));
        const double still = 0;
        if (toliman_sim_frame(sim, &still, 0, 1, 1, frame.data()) == TOLIMAN_OK)
            for (const double counts : frame)
                require(std::isfinite(counts), "a count that is not finite");
    }
    toliman_sim_destroy(sim);
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    return {};
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const auto *json = reinterpret_cast<const char *>(data);
    auto options = toliman::sized<toliman_sim_options>();
    options.threads = 1;
    auto plan = toliman::sized<toliman_sim_plan_info>();
    const toliman_status status = toliman_sim_plan_json(json, size, "nowhere", &options, &plan);
    require(status != TOLIMAN_E_INTERNAL && status != TOLIMAN_E_MEMORY, toliman_last_error());
    if (status != TOLIMAN_OK)
        return 0;
    check(plan);
    fuzz::accepted++;
    if (plan.setup_flops + plan.frame_flops < kMostWork && plan.bytes < 1 << 22)
        make(json, size, options);
    return 0;
}
