// C interface of a mask design of one scene at several position angles.
#include <algorithm>
#include <string>

#include "mask/design.hpp"

using namespace toliman;

namespace {

// Ends a design after so many calls.
int32_t count_down(const char *, double, void *left) {
    return --*static_cast<int *>(left) <= 0 ? 1 : 0;
}

} // namespace

// Returned: cells [N][N]; scores [count][2][3] = own and best, bound, peak to mean, light; small cells; stopped. calls:
// of the progress until it asks to stop, 0 = never.
extern "C" int shim_design(const char *json, const double *angles_deg, int count, unsigned long long seed,
                           int iterations, int symmetry, double peak_to_mean, unsigned workers, int calls,
                           unsigned char *cells, double *scores, double *small) {
    using Kind = Parameter::Kind;
    std::vector<Scene> places;
    for (int i = 0; i < count; i++) {
        places.push_back(read_scene(json, "scene", "."));
        places.back().binary.position_angle_deg = angles_deg[i];
    }
    mask::DesignOptions options;
    options.seed = seed;
    options.free = {{Kind::flux_a}, {Kind::flux_b}, {Kind::shift_x}, {Kind::shift_y}};
    options.peak_to_mean = peak_to_mean;
    options.light_in_frame = 0.5;
    options.symmetry = static_cast<mask::Symmetry>(symmetry);
    options.iterations = static_cast<size_t>(iterations);
    options.draws = 10;
    options.workers = workers;
    if (calls > 0)
        options.progress = {count_down, &calls};
    const mask::Design made = mask::design(places, options);
    std::copy(made.cells.begin(), made.cells.end(), cells);
    for (size_t i = 0; i < places.size(); i++)
        for (const mask::Score &score : {made.own[i], made.best[i]})
            for (const double value : {score.crb_px, score.peak_to_mean, score.light_in_frame})
                *scores++ = value;
    *small = made.small_cells;
    return made.stopped ? 1 : 0;
}
