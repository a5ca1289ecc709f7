// Search for a better mask: spiral masks are drawn at random and the best are varied, all on a coarse version of the
// scene; then the best ones are evaluated and improved with the full scene.
#pragma once
#include "base/progress.hpp"
#include "mask/score.hpp"

namespace toliman::mask {

struct SearchOptions {
    uint64_t seed = 0;
    uint64_t count = 0;   // masks to try; 0 = no limit
    double minutes = 0;   // 0 = no limit
    unsigned workers = 0; // 0 = one per processor
    Progress progress;    // asks to stop: the best mask so far is the result
};

struct Found {
    Mask mask;          // a spiral; clear if no mask is better than the scene's own
    Score own, best;    // with their gradient energies
    uint64_t tried = 0; // masks drawn or varied
    bool improved = false, stopped = false;
};

// Searches until a limit is reached or `progress` asks to stop. Without a time limit the result depends only on scene,
// seed and count. Status::scene if the scene's own mask has no finite bound; Status::unsupported for the padded FFT,
// which models no mask.
Found search(const optics::Simulator &simulator, const SearchOptions &options);

} // namespace toliman::mask
