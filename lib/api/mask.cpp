// include/toliman/mask.h
#include <toliman/mask.h>

#include "api/common.hpp"
#include "api/handles.hpp"
#include "api/parameters.hpp"
#include "information/information.hpp"
#include "mask/design.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_mask : Handle<toliman_mask> {
    static constexpr char kType[] = "toliman_mask";
    std::vector<toliman_mask_info> places;
    std::string json;
    Buffer<uint8_t> cells; // [side][side]
    size_t side = 0;
    std::vector<double> descent_px;
};

namespace {

constexpr size_t kMostDraws = 125;
constexpr double kLargestDate = 1e4, kLargestTurn = 360; // years, degrees: as in a scene

constexpr Choice<mask::Symmetry> kSymmetries = {TOLIMAN_MASK_SYMMETRY_NONE, TOLIMAN_MASK_SYMMETRY_ODD,
                                                "TOLIMAN_MASK_SYMMETRY_..."};

std::vector<Parameter> free_of(const Scene &scene, const char *names) {
    if (names == nullptr)
        return information::eight_nuisances(scene);
    const std::vector<Parameter> known = information::eight_nuisances(scene);
    std::vector<Parameter> free = parameters_of(names, "options->free");
    for (const Parameter parameter : free)
        if (std::find(known.begin(), known.end(), parameter) == known.end())
            fail(Status::argument, "{options->free}: %s: a design of this scene cannot have it free",
                 name_of(parameter).c_str());
    return free;
}

mask::DesignOptions design_options_of(const Scene &scene, const toliman_mask_options &given) {
    mask::DesignOptions known;
    TOLIMAN_COPY(known, given, seed, peak_to_mean);
    known.free = free_of(scene, given.free);
    if (given.light_in_frame > 0 || scene.cadence.peak_photons > 0)
        known.light_in_frame = given.light_in_frame;
    TOLIMAN_COPY(known, given, feature_cells, iterations);
    known.draws = std::clamp<size_t>(known.iterations / 2, 1, kMostDraws);
    known.symmetry = kSymmetries.to_enum(given.symmetry);
    known.workers = given.threads;
    known.progress = {given.progress, given.progress_data};
    return known;
}

// The list's number i, checked.
double listed(const double *values, uint64_t i, double most, const char *name) {
    const double value = (&required(values, name))[i];
    if (!(std::fabs(value) <= most))
        fail(Status::argument, "{options->%s[%llu]} = %g: must be in [%g, %g]", name,
             static_cast<unsigned long long>(i), value, -most, most);
    return value;
}

// The scene with its stars at rest, at each of the places.
std::vector<Scene> places_of(const Scene &scene, const toliman_mask_options &options) {
    const uint64_t dates = options.date_count, angles = options.position_angle_count;
    if (dates > 0 && angles > 0)
        fail(Status::argument, "{options->date_count} = %llu, position_angle_count = %llu: at most one may be above 0",
             static_cast<unsigned long long>(dates), static_cast<unsigned long long>(angles));
    const Scene still = mask::at_rest(scene);
    if (dates > 0 && !still.binary.orbit)
        fail(Status::scene, "%s: {binary.orbit}: dates of a design need the orbit of the stars", scene.source.c_str());
    if (angles > 0 && (still.binary.orbit || still.binary.by_offsets || still.stars.size() < 2))
        fail(Status::scene,
             "%s: {binary.position_angle_deg}: position angles of a design need a binary whose "
             "separation is given",
             scene.source.c_str());
    std::vector<Scene> places(std::max<uint64_t>(std::max(dates, angles), 1), still);
    for (uint64_t i = 0; i < dates; i++)
        places[i].binary.date = listed(options.dates, i, kLargestDate, "dates");
    for (uint64_t i = 0; i < angles; i++)
        places[i].binary.position_angle_deg =
            listed(options.position_angles_deg, i, kLargestTurn, "position_angles_deg");
    return places;
}

toliman_mask_info info_of(const mask::Score &own, const mask::Score &best) {
    toliman_mask_info info = {};
    info.crb_before_px = own.crb_px;
    TOLIMAN_COPY(info, best, crb_px, peak_to_mean, light_in_frame, gradient_energy, radius_50_px, radius_80_px);
    TOLIMAN_COPY(info, best, quantum_px, quantum_flux_shift_px);
    info.peak_to_mean_before = own.peak_to_mean;
    info.light_in_frame_before = own.light_in_frame;
    info.gradient_energy_before = own.gradient_energy;
    info.crb_alone_before_px = own.alone_px;
    info.crb_alone_px = best.alone_px;
    info.crb_flux_shift_before_px = own.flux_shift_px;
    info.crb_flux_shift_px = best.flux_shift_px;
    info.radius_50_before_px = own.radius_50_px;
    info.radius_80_before_px = own.radius_80_px;
    return info;
}

// Scores of a design at all places.
std::vector<toliman_mask_info> infos_of(const mask::Design &made, const mask::DesignOptions &options) {
    std::vector<toliman_mask_info> infos;
    const bool is_improved = mask::is_improved(made, options);
    for (size_t i = 0; i < made.best.size(); i++)
        infos.push_back(info_of(made.own[i], made.best[i]));
    for (toliman_mask_info &info : infos) {
        info.improved = is_improved ? 1 : 0;
        info.stopped = made.stopped ? 1 : 0;
        info.iterations = made.bounds_px.size();
        info.small_features = made.small_cells;
    }
    return infos;
}

} // namespace

extern "C" {

toliman_status toliman_mask_create(const toliman_sim *sim, const toliman_mask_options *options,
                                   toliman_mask **out) noexcept {
    return call(sim, "sim", [&](auto &self) {
        const auto given = accept(options, "options");
        toliman_mask *&made = required(out, "out");
        if (self.simulator.plan().engine == optics::EngineKind::padded_fft)
            fail(Status::unsupported, "{sim}: the engine PADDED_FFT models no mask");
        const Scene &scene = self.simulator.scene();
        const mask::DesignOptions known = design_options_of(scene, given);
        mask::Design design = mask::design(places_of(scene, given), known);
        made = new toliman_mask{{},
                                infos_of(design, known),
                                mask::json_of(design.mask),
                                std::move(design.cells),
                                design.samples,
                                std::move(design.bounds_px)};
    });
}

void toliman_mask_destroy(toliman_mask *mask) noexcept {
    destroy(mask);
}

toliman_status toliman_mask_get_info(const toliman_mask *mask, toliman_mask_info *out) noexcept {
    return call(mask, "mask", [&](auto &self) { deliver(self.places[0], out, "out"); });
}

toliman_status toliman_mask_get_place(const toliman_mask *mask, int64_t place, toliman_mask_info *out) noexcept {
    return call(mask, "mask", [&](auto &self) {
        deliver(self.places[required_index(place, self.places.size(), "place")], out, "out");
    });
}

toliman_status toliman_mask_get_cells(const toliman_mask *mask, size_t side, double *cells) noexcept {
    return call(mask, "mask", [&](auto &self) {
        check_count("side", side, self.side, "the pupil's samples");
        std::copy(self.cells.begin(), self.cells.end(), &required(cells, "cells"));
    });
}

toliman_status toliman_mask_get_descent(const toliman_mask *mask, size_t count, double *bounds_px) noexcept {
    return call(mask, "mask", [&](auto &self) {
        check_count("count", count, self.descent_px.size(), "the iterations");
        if (count > 0)
            std::copy(self.descent_px.begin(), self.descent_px.end(), &required(bounds_px, "bounds_px"));
    });
}

const char *toliman_mask_get_json(const toliman_mask *mask) noexcept {
    if (mask == nullptr)
        return "";
    try {
        return Use(mask, "mask")->json.c_str();
    } catch (...) {
        status_of_exception();
        return "";
    }
}

} // extern "C"
