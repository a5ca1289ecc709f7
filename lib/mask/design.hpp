// A mask by gradient: descends from the best of some random spirals on the Cramer-Rao bound with nuisances free.
#pragma once
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "mask/level_set.hpp"
#include "mask/score.hpp"

namespace toliman::mask {

struct DesignOptions {
    uint64_t seed = 0;
    std::vector<Parameter> free;   // nuisances, as in Objective
    double peak_to_mean = 0;       // largest of each place's frame; 0 = that of the scene's mask
    double light_in_frame = 0.875; // smallest, as far as the frame allows
    size_t feature_cells = 2;      // side of the smallest feature
    Symmetry symmetry = Symmetry::none;
    size_t draws = 120, iterations = 250; // random spirals; of the first descent
    unsigned workers = 0;                 // 0 = one per processor
    Progress progress;                    // asks to stop: the mask so far is the result
};

struct Design {
    size_t samples = 0;
    Buffer<uint8_t> cells;         // [samples][samples], 1 where the mask steps
    Mask mask;                     // a binary file of these cells, not yet named
    std::vector<Score> own, best;  // of the scene's mask and of this one, at each place, with gradient energies
    std::vector<double> bounds_px; // of the sketch in each iteration
    double small_cells = 0;        // fraction of the open cells that are in smaller features
    bool stopped = false;
};

// Whether each place has a smaller bound and a peak within its limit.
bool is_improved(const Design &design, const DesignOptions &options) noexcept;

// The group "mask" of a scene with the cells in mask.npy. The numbers have the fewest digits that are read as the same
// bits, in every locale.
std::string json_of(const Mask &mask);

// The scene with its stars at rest, and no systematics but jitter and smear.
Scene at_rest(Scene scene);

// places: scenes of one instrument, whose stars have the places that the mask is designed for. The result depends on
// the scenes and options only, not on the workers. Status::scene if a place has no bound with these nuisances free;
// Status::unsupported as in Objective.
Design design(const std::vector<Scene> &places, const DesignOptions &options);

} // namespace toliman::mask
