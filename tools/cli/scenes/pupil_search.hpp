// The search for a better mask: spiral masks are drawn at random, the best are varied, all on a sketch of the scene;
// then the whole scene judges and improves what was found.
#pragma once
#include <chrono>
#include <functional>
#include <vector>

#include "common/terminal.hpp"
#include "scenes/masked_scene.hpp"

namespace cli {

struct Found {
    Terms terms; // none: the scene's own mask
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

    // Searches until a limit or a signal; where nothing better is found, the last tries are left out. Without a time
    // limit the result depends on scene, seed and count alone: masks are judged in batches of a fixed size, whatever
    // the number of threads.
    Found run();
    uint64_t tried() const noexcept { return tried_; } // masks drawn or varied

  private:
    using Batch = std::vector<Terms>;
    using Clock = std::chrono::steady_clock;
    struct Stage {
        const char *name;
        double count_until; // of the masks to try
        double time_until;  // of the time
    };

    void work(const Stage &stage, const std::function<void(size_t count, double fraction)> &batch);
    std::vector<Score> judge(const MaskedScene &scene, const Batch &batch);
    bool fits(const Score &score) const noexcept { return score.peak_to_mean <= own_.peak_to_mean; }
    void draw(size_t count);
    void refine(size_t count, size_t live);
    void keep_best(const Batch &batch);
    void confirm();
    void polish(size_t count);

    MaskedScene whole_, sketch_;
    Terms own_terms_;
    Score own_;
    Found best_;
    std::vector<Found> lines_; // lines of descent, judged on the sketch, best first
    SearchLimits limits_;
    Progress &progress_;
    Clock::time_point start_ = Clock::now();
    uint64_t tried_ = 0, judged_ = 0; // judged: with the scene's own, and those that are judged twice
};

} // namespace cli
