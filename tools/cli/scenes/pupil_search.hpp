// Search for a better mask: spiral masks are drawn at random and the best are varied, all on a coarse version of the
// scene; then the best ones are evaluated and improved with the full scene.
#pragma once
#include <chrono>
#include <functional>
#include <vector>

#include "common/terminal.hpp"
#include "scenes/masked_scene.hpp"

namespace cli {

struct Found {
    Terms terms; // empty: the scene's own mask
    Score score;
};

struct SearchLimits {
    uint64_t seed = 1;
    uint64_t count = 0; // masks to try; 0 = no limit
    double minutes = 0; // 0 = no limit
};

class PupilSearch {
  public:
    // own: the score of the scene's mask. A mask is accepted if its peak-to-mean ratio is at most that of own.
    PupilSearch(const MaskedScene &scene, const Score &own, const SearchLimits &limits, Progress &progress);

    // Searches until a limit or a signal. If no better mask is found, the last stage (polish) is left out. Without a
    // time limit the result depends only on scene, seed and count: masks are evaluated in batches of a fixed size, for
    // any number of threads.
    Found run();
    uint64_t tried() const noexcept { return tried_; } // masks drawn or varied

  private:
    using Batch = std::vector<Terms>;
    using Clock = std::chrono::steady_clock;
    struct Stage {
        const char *name;
        double count_until; // fraction of the masks to try at the end of the stage
        double time_until;  // fraction of the time at the end of the stage
    };

    void work(const Stage &stage, const std::function<void(size_t count, double fraction)> &batch);
    std::vector<Score> evaluate(const MaskedScene &scene, const Batch &batch);
    bool fits(const Score &score) const noexcept { return score.peak_to_mean <= own_.peak_to_mean; }
    void draw(size_t count);
    void refine(size_t count, size_t active);
    void keep_best(const Batch &batch);
    void confirm();
    void polish(size_t count);

    MaskedScene full_, coarse_;
    Terms own_terms_;
    Score own_;
    Found best_;
    std::vector<Found> candidates_; // evaluated on the coarse scene, best first
    SearchLimits limits_;
    Progress &progress_;
    Clock::time_point start_ = Clock::now();
    uint64_t tried_ = 0, evaluated_ = 0; // evaluated_: also the scene's own mask and second evaluations
};

} // namespace cli
