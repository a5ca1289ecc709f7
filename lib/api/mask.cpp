// include/toliman/mask.h
#include <toliman/mask.h>

#include "api/guard.hpp"
#include "api/handles.hpp"
#include "mask/search.hpp"
#include "mask/spiral.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_mask : Handle<toliman_mask> {
    static constexpr char kType[] = "toliman_mask";
    mask::Found found;
    std::string json;
};

namespace {

constexpr uint64_t kDefaultCount = 4000;
constexpr double kMostMinutes = 100000;

mask::SearchOptions search_options_of(const toliman_mask_options *options) {
    const auto known = accept(options, toliman_mask_options{}, "options");
    if (!(known.minutes >= 0 && known.minutes <= kMostMinutes))
        fail(Status::argument, "{options->minutes} = %g: must be in [0, %g]", known.minutes, kMostMinutes);
    const uint64_t count = known.count != 0 || known.minutes > 0 ? known.count : kDefaultCount;
    return {known.seed, count, known.minutes, known.threads, {known.progress, known.progress_data}};
}

} // namespace

extern "C" {

void toliman_mask_options_init(toliman_mask_options *options, size_t size) noexcept {
    deliver_defaults(toliman_mask_options{}, options, size);
}

toliman_status toliman_mask_search(const toliman_sim *sim, const toliman_mask_options *options,
                                   toliman_mask **out) noexcept {
    return guard([&] {
        const Use use(sim, "sim");
        toliman_mask *&made = required(out, "out");
        const mask::Found found = mask::search(use->simulator, search_options_of(options));
        made = new toliman_mask{{}, found, found.improved ? mask::json_of(found.mask) : ""};
    });
}

void toliman_mask_destroy(toliman_mask *mask) noexcept {
    destroy(mask);
}

toliman_status toliman_mask_get_info(const toliman_mask *mask, toliman_mask_info *out) noexcept {
    return guard([&] {
        const Use use(mask, "mask");
        const mask::Found &found = use->found;
        toliman_mask_info info = {};
        info.improved = found.improved ? 1 : 0;
        info.stopped = found.stopped ? 1 : 0;
        info.tried = found.tried;
        info.crb_before_px = found.own.crb_px;
        info.crb_px = found.best.crb_px;
        info.peak_to_mean_before = found.own.peak_to_mean;
        info.peak_to_mean = found.best.peak_to_mean;
        info.light_in_frame_before = found.own.light_in_frame;
        info.light_in_frame = found.best.light_in_frame;
        info.gradient_energy_before = found.own_gradient_energy;
        info.gradient_energy = found.gradient_energy;
        deliver(info, out, "out");
    });
}

const char *toliman_mask_get_json(const toliman_mask *mask) noexcept {
    return mask != nullptr ? mask->json.c_str() : "";
}

} // extern "C"
