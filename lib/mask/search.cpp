// Method: random search in four stages. draw: 35 % of the masks are random; the best eight are candidates. refine (to
// 97.5 %): children of 8, 4, 2 and finally 1 candidate; a better child replaces its parent. Both use the coarse scene.
// confirm: the full scene evaluates the candidates. polish: small variations of the best mask with the full scene.
// The figure of merit is the Cramer-Rao bound; masks above the peak-to-mean ratio of the scene's own mask are rejected.
// Why random: the sampled sign of a sum, and with it the bound, is piecewise constant in the terms: it has no gradient.
// Batches have a fixed size and random numbers depend on (seed, number), so the result is independent of the threads.
// Reference: Spall 2003, Introduction to Stochastic Search and Optimization, chapter 2.
#include "mask/search.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "base/text.hpp"
#include "base/workers.hpp"
#include "mask/spiral.hpp"

namespace toliman::mask {

namespace {

constexpr size_t kBatch = 16, kCandidates = 8;
constexpr double kLargeReach = 0.5, kSmallReach = 0.1; // largest step of a variation

struct Candidate {
    Terms terms; // empty: the scene's own mask
    Score score;
};

bool better(const Candidate &a, const Candidate &b) {
    return a.score.crb_px < b.score.crb_px;
}

struct Stage {
    const char *name;
    double count_until; // fraction of the masks to try at the end of the stage
    double time_until;  // fraction of the time at the end of the stage
};

class Search {
  public:
    Search(const optics::Simulator &simulator, const SearchOptions &options)
        : own_(score_of(simulator.images(), simulator.light())), best_{{}, own_}, step_(step_of(simulator)),
          full_(without_signal(simulator.scene())), coarse_(coarse(full_, mask_of(draw_terms(0, 0)))),
          options_(options) {
        own_.gradient_energy = optics::gradient_energy(simulator.images());
    }

    Found run();

  private:
    using Batch = std::vector<Terms>;
    using Clock = std::chrono::steady_clock;

    static Mask step_of(const optics::Simulator &simulator);
    Mask mask_of(const Terms &terms) const;
    void work(const Stage &stage, const std::function<void(size_t count, double fraction)> &batch);
    void report(const Stage &stage, double fraction);
    std::vector<Score> evaluate(const Scene &scene, const Batch &batch);
    bool fits(const Score &score) const noexcept { return score.peak_to_mean <= own_.peak_to_mean; }
    void draw(size_t count);
    void refine(size_t count, size_t active);
    void keep_best(const Batch &batch);
    void confirm();
    void polish(size_t count);

    Score own_;
    Candidate best_; // evaluated with the full scene
    Mask step_;      // a spiral without terms, with the step of every mask
    Scene full_, coarse_;
    std::vector<Candidate> candidates_; // evaluated with the coarse scene, best first
    SearchOptions options_;
    Clock::time_point start_ = Clock::now();
    uint64_t tried_ = 0, evaluated_ = 0; // evaluated_: also the scene's own mask and second evaluations
    bool stopped_ = false;
};

// The step of the scene's own mask or, if it has none, half of the middle wavelength: a phase step of pi. Edges,
// rotation and shift of a spiral are kept; a scene that has none gets averages over areas.
Mask Search::step_of(const optics::Simulator &simulator) {
    const Mask &own = simulator.scene().telescope.mask;
    Mask step = own;
    if (own.kind != Mask::Kind::spiral)
        step.edges = Mask::Edges::area;
    step.kind = Mask::Kind::spiral;
    step.terms.clear();
    const std::vector<double> &wavelength = simulator.light().wavelength_m;
    const auto [least, most] = std::minmax_element(wavelength.begin(), wavelength.end());
    if (own.step_m() == 0)
        step.opd_nm = std::nearbyint((*least + *most) / 4 * 1e10) / 10;
    return step;
}

Mask Search::mask_of(const Terms &terms) const {
    Mask mask = step_;
    mask.terms = terms;
    return mask;
}

// A mask with which the scene is invalid, for example too bright, has an infinite bound.
std::vector<Score> Search::evaluate(const Scene &scene, const Batch &batch) {
    std::vector<Score> scores(batch.size());
    run_jobs(worker_count(options_.workers), batch.size(), [&](size_t i) {
        try {
            scores[i] = score_of(scene, mask_of(batch[i]));
        } catch (const Error &error) {
            if (error.status() != Status::scene)
                throw;
        }
    });
    evaluated_ += batch.size();
    return scores;
}

void Search::report(const Stage &stage, double fraction) {
    char text[100];
    const bool confirmed = candidates_.empty() || !best_.terms.empty();
    print_text(text, sizeof text, "%s: best %.4g px", stage.name,
               confirmed ? best_.score.crb_px : candidates_[0].score.crb_px);
    stopped_ = options_.progress.asks_to_stop(text, fraction);
}

// Calls `batch` with the number of masks to try and the completed fraction of the stage until the stage ends.
void Search::work(const Stage &stage, const std::function<void(size_t count, double fraction)> &batch) {
    const double quota =
        std::ceil(stage.count_until * static_cast<double>(options_.count)) - static_cast<double>(tried_);
    const double end = stage.time_until * 60 * options_.minutes;
    const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start_).count(); };
    const double begin = elapsed();
    for (double done = 0; !stopped_;) {
        const double by_count = options_.count == 0 ? 0 : done < quota ? done / quota : 1;
        const double by_time = options_.minutes > 0 ? (elapsed() - begin) / std::max(end - begin, 1e-9) : 0;
        const double fraction = std::min(std::max(by_count, by_time), 1.0);
        report(stage, fraction);
        if (fraction >= 1 || stopped_)
            return;
        const double left = options_.count > 0 ? quota - done : kBatch;
        const auto count = static_cast<size_t>(std::min<double>(left, kBatch));
        batch(count, fraction);
        tried_ += count;
        done += static_cast<double>(count);
    }
}

void Search::draw(size_t count) {
    Batch batch;
    for (size_t i = 0; i < count; i++)
        batch.push_back(draw_terms(options_.seed, evaluated_ + i));
    const std::vector<Score> scores = evaluate(coarse_, batch);
    for (size_t i = 0; i < count; i++)
        if (fits(scores[i]))
            candidates_.push_back({batch[i], scores[i]});
    std::stable_sort(candidates_.begin(), candidates_.end(), better);
    candidates_.resize(std::min(candidates_.size(), kCandidates));
}

// Varies the first `active` candidates in turn; a better mask replaces the one it was made from.
void Search::refine(size_t count, size_t active) {
    Batch batch;
    for (size_t i = 0; i < count; i++)
        batch.push_back(vary_terms(candidates_[i % active].terms, kLargeReach, options_.seed, evaluated_ + i));
    const std::vector<Score> scores = evaluate(coarse_, batch);
    for (size_t i = 0; i < count; i++)
        if (fits(scores[i]) && scores[i].crb_px < candidates_[i % active].score.crb_px)
            candidates_[i % active] = {batch[i], scores[i]};
    std::stable_sort(candidates_.begin(), candidates_.end(), better);
}

// Evaluates masks with the full scene and keeps the best.
void Search::keep_best(const Batch &batch) {
    const std::vector<Score> scores = evaluate(full_, batch);
    for (size_t i = 0; i < batch.size(); i++)
        if (fits(scores[i]) && scores[i].crb_px < best_.score.crb_px)
            best_ = {batch[i], scores[i]};
}

// Evaluates the candidates; if the search was stopped only the best one, so that it ends soon.
void Search::confirm() {
    Batch batch;
    for (const Candidate &candidate : candidates_)
        if (batch.empty() || !stopped_)
            batch.push_back(candidate.terms);
    keep_best(batch);
}

void Search::polish(size_t count) {
    Batch batch;
    for (size_t i = 0; i < count; i++)
        batch.push_back(vary_terms(best_.terms, kSmallReach, options_.seed, evaluated_ + i));
    keep_best(batch);
}

Found Search::run() {
    const Terms &own_terms = full_.telescope.mask.terms;
    if (!own_terms.empty())
        candidates_.push_back({own_terms, evaluate(coarse_, {own_terms})[0]});
    work({"draw", 0.35, 0.3}, [&](size_t count, double) { draw(count); });
    if (!candidates_.empty())
        work({"refine", 0.975, 0.8}, [&](size_t count, double fraction) { // 8, 4, 2, 1 candidates
            const size_t active = kCandidates >> static_cast<size_t>(4 * fraction);
            refine(count, std::clamp<size_t>(active, 1, candidates_.size()));
        });
    confirm();
    if (!best_.terms.empty())
        work({"polish", 1, 1}, [&](size_t count, double) { polish(count); });
    const bool improved = !best_.terms.empty();
    Found found;
    found.own = own_;
    found.best = best_.score;
    found.best.gradient_energy = own_.gradient_energy;
    found.tried = tried_;
    found.improved = improved;
    found.stopped = stopped_;
    if (improved) {
        found.mask = mask_of(best_.terms);
        found.best.gradient_energy = full_score_of(full_, found.mask).gradient_energy;
    }
    return found;
}

} // namespace

Found search(const optics::Simulator &simulator, const SearchOptions &options) {
    const char *source = simulator.scene().source.c_str();
    if (simulator.plan().engine != optics::EngineKind::matrix_dft)
        fail(Status::unsupported, "%s: the engine PADDED_FFT models no mask: use MATRIX_DFT", source);
    if (!std::isfinite(optics::bound_with(simulator.images(), {})))
        fail(Status::scene, "%s: masks cannot be compared: the separation has no Cramer-Rao bound", source);
    return Search(simulator, options).run();
}

} // namespace toliman::mask
