// Method: random search in four stages. draw: 35 % of the masks are random; the best eight are candidates. refine (to
// 97.5 %): children of 8, 4, 2 and finally 1 candidate; a better child replaces its parent. Both use the coarse scene.
// confirm: the full scene evaluates the candidates. polish: small variations of the best mask with the full scene.
// The figure of merit is the Cramer-Rao bound; masks above the peak-to-mean ratio of the scene's own mask are rejected.
// Batches have a fixed size and random numbers depend on (seed, number), so the result is independent of the threads.
#include "scenes/pupil_search.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <thread>

#include "common/text.hpp"

namespace cli {

namespace {

constexpr size_t kBatch = 16, kCandidates = 8;
constexpr double kLargeReach = 0.5, kSmallReach = 0.1; // largest step of a variation

bool better(const Found &a, const Found &b) {
    return a.score.crb_px < b.score.crb_px;
}

// Calls job(0) ... job(count - 1) on all processors; the exception of a job that failed is thrown again.
void on_all_processors(size_t count, const std::function<void(size_t)> &job) {
    std::atomic<size_t> next{0};
    const auto work = [&] {
        for (size_t i; (i = next++) < count;)
            job(i);
    };
    std::vector<std::future<void>> threads;
    for (size_t i = 0; i < std::min<size_t>(count, std::max(1U, std::thread::hardware_concurrency())); i++)
        threads.push_back(std::async(std::launch::async, work));
    for (std::future<void> &thread : threads)
        thread.get();
}

} // namespace

PupilSearch::PupilSearch(const MaskedScene &scene, const Score &own, const SearchLimits &limits, Progress &progress)
    : full_(scene.without_signal()), coarse_(full_.coarse()), own_terms_(terms_of(scene.own_mask())),
      own_(own), best_{{}, own}, limits_(limits), progress_(progress) {}

std::vector<Score> PupilSearch::evaluate(const MaskedScene &scene, const Batch &batch) {
    std::vector<Score> scores(batch.size());
    on_all_processors(batch.size(), [&](size_t i) {
        try {
            scores[i] = scene.evaluate(batch[i]);
        } catch (const toliman::error &error) {
            if (error.status() !=
                TOLIMAN_E_SCENE) // the scene is invalid with this mask, e.g. too bright: not a candidate
                throw;
        }
    });
    evaluated_ += batch.size();
    return scores;
}

void PupilSearch::work(const Stage &stage, const std::function<void(size_t count, double fraction)> &batch) {
    const double quota =
        std::ceil(stage.count_until * static_cast<double>(limits_.count)) - static_cast<double>(tried_);
    const double end = stage.time_until * 60 * limits_.minutes;
    const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start_).count(); };
    const double begin = elapsed();
    for (double done = 0; stop_signal() == 0;) {
        const double by_count = limits_.count == 0 ? 0 : done < quota ? done / quota : 1;
        const double by_time = limits_.minutes > 0 ? (elapsed() - begin) / std::max(end - begin, 1e-9) : 0;
        const double fraction = std::min(std::max(by_count, by_time), 1.0);
        const double least =
            candidates_.empty() || !best_.terms.empty() ? best_.score.crb_px : candidates_[0].score.crb_px;
        progress_.show(stage.name, fraction, formatted("best %.4g px", least));
        if (fraction >= 1)
            return;
        const double left = limits_.count > 0 ? quota - done : kBatch;
        const auto count = static_cast<size_t>(std::min<double>(left, kBatch));
        batch(count, fraction);
        tried_ += count;
        done += static_cast<double>(count);
    }
}

void PupilSearch::draw(size_t count) {
    Batch batch;
    for (size_t i = 0; i < count; i++)
        batch.push_back(draw_terms(limits_.seed, evaluated_ + i));
    const std::vector<Score> scores = evaluate(coarse_, batch);
    for (size_t i = 0; i < count; i++)
        if (fits(scores[i]))
            candidates_.push_back({batch[i], scores[i]});
    std::stable_sort(candidates_.begin(), candidates_.end(), better);
    candidates_.resize(std::min(candidates_.size(), kCandidates));
}

// Varies the first `active` candidates in turn; a better mask replaces the one it was made from.
void PupilSearch::refine(size_t count, size_t active) {
    Batch batch;
    for (size_t i = 0; i < count; i++)
        batch.push_back(vary_terms(candidates_[i % active].terms, kLargeReach, limits_.seed, evaluated_ + i));
    const std::vector<Score> scores = evaluate(coarse_, batch);
    for (size_t i = 0; i < count; i++)
        if (fits(scores[i]) && scores[i].crb_px < candidates_[i % active].score.crb_px)
            candidates_[i % active] = {batch[i], scores[i]};
    std::stable_sort(candidates_.begin(), candidates_.end(), better);
}

// Evaluates masks with the full scene and keeps the best.
void PupilSearch::keep_best(const Batch &batch) {
    const std::vector<Score> scores = evaluate(full_, batch);
    for (size_t i = 0; i < batch.size(); i++)
        if (fits(scores[i]) && scores[i].crb_px < best_.score.crb_px)
            best_ = {batch[i], scores[i]};
}

// Evaluates the candidates; after a signal only the best one, so that the program ends soon.
void PupilSearch::confirm() {
    Batch batch;
    for (const Found &candidate : candidates_)
        if (batch.empty() || stop_signal() == 0)
            batch.push_back(candidate.terms);
    keep_best(batch);
}

void PupilSearch::polish(size_t count) {
    Batch batch;
    for (size_t i = 0; i < count; i++)
        batch.push_back(vary_terms(best_.terms, kSmallReach, limits_.seed, evaluated_ + i));
    keep_best(batch);
}

Found PupilSearch::run() {
    if (!own_terms_.empty())
        candidates_.push_back({own_terms_, evaluate(coarse_, {own_terms_})[0]});
    work({"draw", 0.35, 0.3}, [&](size_t count, double) { draw(count); });
    if (!candidates_.empty())
        work({"refine", 0.975, 0.8}, [&](size_t count, double fraction) { // 8, 4, 2, 1 candidates
            const size_t active = kCandidates >> static_cast<size_t>(4 * fraction);
            refine(count, std::clamp<size_t>(active, 1, candidates_.size()));
        });
    confirm();
    if (!best_.terms.empty())
        work({"polish", 1, 1}, [&](size_t count, double) { polish(count); });
    return best_;
}

} // namespace cli
