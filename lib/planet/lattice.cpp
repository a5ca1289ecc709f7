// Method: midpoint rule on a lattice of cells in frequency (steps of a fifth of 1/span), shares of the prior of the
// eccentricity and of the jitter, and mean anomaly. In turns, each axis in which the logarithm of neighbouring nodes
// differs by more than 0.6, as the rms over the posterior, is halved: in a Gaussian posterior, cells are then smaller
// than 0.6 of its conditional standard deviation. Only cells are divided whose logarithm is within 8 of the largest,
// plus half of the differences from their neighbours: more than the logarithm may rise inside a cell around a peak.
// So the limit is wide for strong signals at first, and follows their peak down to widths of 1e-5 cells. All other
// cells keep their mass. Nodes are independent of each other and sums are taken in the order of the cells, so that
// the threads do not change a bit.
//
// Rejected: Markov chains, whose convergence needs a judgement; refining around the highest node only, which loses the
// weaker of two periods.
// Reference: Price-Whelan et al. (2017), ApJ 837, 20, sample the same posterior at random
#include "planet/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/error.hpp"
#include "base/workers.hpp"

namespace toliman::planet {

namespace {

constexpr double kMostDifference = 0.6; // rms of neighbouring logarithms over the posterior
constexpr double kCut = 8;              // of logarithms, below the largest
constexpr double kRise = 0.5;           // of the differences from the neighbours: the rise inside a cell
constexpr double kFrequencyStep = 0.2;  // of 1/span
constexpr int32_t kEccentricities = 8, kAnomalies = 16, kJitters = 8;
constexpr size_t kMostCells = 20'000'000, kMostRefined = 1'000'000, kChunk = 256;
constexpr size_t kLeastRefined = 4096;    // of a level, when kMostWork is reached
constexpr size_t kMostWork = 400'000'000; // refined cells times measurements: about 5 s of one processor
constexpr size_t kScaleWork = 8;          // of a scale of the amplitudes, in measurements
constexpr int kMostLevels = 100;
constexpr int32_t kMostCount = 1 << 29;

size_t cell_count(const Level &level) noexcept {
    size_t count = 1;
    for (const int32_t n : level.counts)
        count *= static_cast<size_t>(n);
    return count;
}

bool before(const Cell &a, const Cell &b) noexcept {
    return a.place < b.place;
}

// Finds the neighbours of consecutive cells in one direction of an axis. As the cells are in order, so are their
// neighbours, but for those around the circle of the mean anomaly.
class Neighbours {
  public:
    Neighbours(const std::vector<Cell> &active, const Level &level, size_t axis, int direction) noexcept
        : active_(active), count_(level.counts[axis]), axis_(axis), direction_(direction), next_(active.end()) {}

    // The neighbour of a cell, which is not before that of the last call; NULL if there is none.
    const Cell *of(const Cell &cell) noexcept {
        Cell at = cell;
        at.place[axis_] += direction_;
        const bool is_around = axis_ == kAnomaly && (at.place[axis_] < 0 || at.place[axis_] == count_);
        if (is_around)
            at.place[axis_] = (at.place[axis_] + count_) % count_;
        auto found = next_;
        if (next_ == active_.end() || is_around)
            found = std::lower_bound(active_.begin(), active_.end(), at, before);
        while (found != active_.end() && before(*found, at))
            ++found;
        if (!is_around)
            next_ = found;
        return found != active_.end() && found->place == at.place ? &*found : nullptr;
    }

  private:
    const std::vector<Cell> &active_;
    int32_t count_;
    size_t axis_;
    int direction_;
    std::vector<Cell>::const_iterator next_;
};

size_t highest(const std::vector<Cell> &cells) noexcept {
    const auto lower = [](const Cell &a, const Cell &b) { return a.log_mass < b.log_mass; };
    return static_cast<size_t>(std::max_element(cells.begin(), cells.end(), lower) - cells.begin());
}

// All cells of a level, in order.
std::vector<Cell> all_cells(const Level &level) {
    std::vector<Cell> cells(cell_count(level));
    for (size_t i = 0; i < cells.size(); i++) {
        size_t rest = i;
        for (size_t axis = kAxes; axis-- > 0;) {
            const auto count = static_cast<size_t>(level.counts[axis]);
            cells[i].place[axis] = static_cast<int32_t>(rest % count);
            rest /= count;
        }
    }
    return cells;
}

double log_sum(const std::vector<Cell> &cells) noexcept {
    const double largest = cells[highest(cells)].log_mass;
    double sum = 0;
    for (const Cell &cell : cells)
        sum += std::exp(cell.log_mass - largest);
    return largest + std::log(sum);
}

// How much neighbours differ: for each axis as the rms over the posterior, and for each cell the sum over the axes of
// the largest difference.
struct Roughness {
    std::array<double, kAxes> mean = {};
    std::vector<double> each;
};

// Weighted sums of squared differences.
struct Sums {
    std::array<double, kAxes> squares = {}, weights = {};
};

// Adds the differences of the cells from `first` on along an axis.
void add_differences(const std::vector<Cell> &active, const Level &level, size_t axis, size_t first, size_t end,
                     double largest, Sums &sums, std::vector<double> &each) noexcept {
    Neighbours neighbours[] = {{active, level, axis, -1}, {active, level, axis, 1}};
    for (size_t i = first; i < end; i++) {
        const double weight = std::exp(active[i].log_mass - largest);
        double most = 0;
        for (Neighbours &side : neighbours)
            if (const Cell *const next = side.of(active[i])) {
                const double difference = std::fabs(active[i].log_mass - next->log_mass);
                sums.squares[axis] += weight * difference * difference;
                sums.weights[axis] += weight;
                most = std::max(most, difference);
            }
        each[i] += most;
    }
}

Roughness roughness(const std::vector<Cell> &active, const Level &level, unsigned threads) {
    Roughness rough;
    rough.each.resize(active.size());
    const double largest = active[highest(active)].log_mass;
    std::vector<Sums> parts((active.size() + kChunk - 1) / kChunk);
    run_jobs(worker_count(threads), parts.size(), [&](size_t part) {
        for (size_t axis = 0; axis < kAxes; axis++)
            if (level.counts[axis] > 1)
                add_differences(active, level, axis, part * kChunk, std::min(active.size(), (part + 1) * kChunk),
                                largest, parts[part], rough.each);
    });
    for (size_t axis = 0; axis < kAxes; axis++) {
        double square = 0, weight = 0;
        for (const Sums &part : parts) {
            square += part.squares[axis];
            weight += part.weights[axis];
        }
        rough.mean[axis] = weight > 0 ? std::sqrt(square / weight) : 0;
    }
    return rough;
}

// Whether each axis is divided: those whose differences are too large.
std::array<bool, kAxes> axes_to_split(const Roughness &rough, const Level &level) {
    std::array<bool, kAxes> split = {};
    for (size_t axis = 0; axis < kAxes; axis++)
        split[axis] = rough.mean[axis] > kMostDifference && level.counts[axis] < kMostCount;
    return split;
}

// Whether each cell is divided: those that may contain a part of the posterior, and at most `most` of them.
std::vector<bool> cells_to_split(const std::vector<Cell> &active, const Roughness &rough, size_t most) {
    std::vector<double> highest_inside(active.size());
    for (size_t i = 0; i < active.size(); i++)
        highest_inside[i] = active[i].log_mass + kRise * rough.each[i];
    double least = active[highest(active)].log_mass - kCut;
    if (active.size() > most) {
        std::vector<double> sorted = highest_inside;
        const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(most);
        std::nth_element(sorted.begin(), place, sorted.end(), std::greater<>());
        least = std::max(least, std::nextafter(*place, HUGE_VAL));
    }
    std::vector<bool> is_split(active.size());
    for (size_t i = 0; i < active.size(); i++)
        is_split[i] = highest_inside[i] >= least;
    return is_split;
}

} // namespace

Lattice::Lattice(const Problem &problem, unsigned threads, const Progress &progress, const char *stage)
    : problem_(problem), stage_(stage) {
    set_null(threads);
    set_first_level();
    Active active = all_cells(levels_.back());
    double done = 0;
    size_t left = kMostWork / (problem_.series.rows + kScaleWork * problem_.prior.scales.size());
    for (int turn = 0;; turn++) {
        const double next = turn == 0 ? 0.5 : (1 + done) / 2;
        prepare(active);
        evaluate(active, threads, progress, done, next);
        done = next;
        const Level &level = levels_.back();
        const Roughness rough = roughness(active, level, threads);
        const std::array<bool, kAxes> split = axes_to_split(rough, level);
        const auto axes = std::count(split.begin(), split.end(), true);
        const size_t most = std::clamp(left, kLeastRefined, kMostRefined) >> axes;
        const std::vector<bool> is_split = cells_to_split(active, rough, most);
        const bool ends = axes == 0 || turn + 1 == kMostLevels;
        Active kept;
        for (size_t i = 0; i < active.size(); i++)
            (is_split[i] && !ends ? kept : cells_).push_back(active[i]);
        if (kept.empty())
            break;
        active = children(kept, split);
        left -= std::min(left, active.size());
    }
    progress.report(stage, 1);
    best_ = highest(cells_);
    log_evidence_ = log_sum(cells_);
}

// The integral over the jitter without a planet, by the midpoint rule with cells a quarter of the width of its
// posterior, which is at least 1/sqrt(2 n) of the jitter.
void Lattice::set_null(unsigned threads) {
    const Prior &prior = problem_.prior;
    size_t count = 1;
    if (prior.jitter_max > 0) {
        const double range = std::log1p(prior.jitter_max / prior.jitter_knee);
        const double width = 1 / std::sqrt(2.0 * static_cast<double>(problem_.series.used));
        count = static_cast<size_t>(std::clamp(std::ceil(4 * range / width), 16.0, 2000.0));
    }
    const auto made = [&](size_t i) {
        const double jitter = prior.jitter((static_cast<double>(i) + 0.5) / static_cast<double>(count));
        return std::make_unique<Design>(problem_.series, problem_.functions, problem_.values, jitter);
    };
    std::vector<double> logs(count);
    run_jobs(worker_count(threads), count, [&](size_t i) { logs[i] = made(i)->log_null(); });
    const auto best = std::max_element(logs.begin(), logs.end());
    double sum = 0;
    for (const double log : logs)
        sum += std::exp(log - *best);
    log_null_ = *best + std::log(sum / static_cast<double>(count));
    null_ = made(static_cast<size_t>(best - logs.begin()));
}

void Lattice::set_first_level() {
    const Prior &prior = problem_.prior;
    const double steps = (prior.frequency_max - prior.frequency_min) * problem_.series.span / kFrequencyStep;
    if (!(steps < static_cast<double>(kMostCells)))
        fail(Status::range, "{options->period_min} = %.9g: too short for the span of the series: %.3g frequencies",
             1 / prior.frequency_max, steps);
    Level level = {};
    level.counts[kJitter] = prior.jitter_max > 0 ? kJitters : 1;
    level.counts[kEccentricity] = kEccentricities;
    level.counts[kFrequency] = std::max(4, static_cast<int32_t>(std::ceil(steps)));
    level.counts[kAnomaly] = kAnomalies;
    if (cell_count(level) > kMostCells)
        fail(Status::range,
             "{options->period_min} = %.9g: too short for the span of the series: %zu nodes, at most %zu",
             1 / prior.frequency_max, cell_count(level), kMostCells);
    levels_.push_back(level);
}

// Makes the designs of all jitters of the cells.
void Lattice::prepare(const Active &active) {
    for (const Cell &cell : active) {
        auto &design = designs_[{levels_.back().counts[kJitter], cell.place[kJitter]}];
        if (design == nullptr)
            design = std::make_unique<Design>(problem_.series, problem_.functions, problem_.values,
                                              node(cell, {0.5, 0.5, 0.5, 0.5}).jitter);
    }
}

void Lattice::evaluate(Active &active, unsigned threads, const Progress &progress, double from, double to) {
    const Level &level = levels_.back();
    const Prior &prior = problem_.prior;
    const double step = (prior.frequency_max - prior.frequency_min) / level.counts[kFrequency];
    const double others = -std::log(static_cast<double>(level.counts[kJitter]) * level.counts[kEccentricity] *
                                    static_cast<double>(level.counts[kAnomaly]));
    const size_t chunks = (active.size() + kChunk - 1) / kChunk;
    run_jobs(
        worker_count(threads), chunks,
        [&](size_t chunk) {
            ShapeWork work(problem_.series);
            double eccentricity = 0;
            int32_t known = -1; // place of `eccentricity`
            const size_t end = std::min(active.size(), (chunk + 1) * kChunk);
            for (size_t i = chunk * kChunk; i < end; i++) {
                Cell &cell = active[i];
                const Place &place = cell.place;
                if (place[kEccentricity] != known) {
                    known = place[kEccentricity];
                    eccentricity = prior.eccentricity((known + 0.5) / level.counts[kEccentricity]);
                }
                const double low = prior.frequency_min + step * place[kFrequency];
                const Orbit orbit = {low + step / 2, eccentricity, (place[kAnomaly] + 0.5) / level.counts[kAnomaly]};
                const Design &at = design(level.counts[kJitter], place[kJitter]);
                cell.log_mass = at.log_null() +
                                log_bayes(work.moments(problem_.series, at, orbit), prior.scales, nullptr) +
                                std::log(prior.share(low, low + step)) + others;
            }
        },
        [&](double part) { progress.report(stage_, from + (to - from) * part); });
}

Lattice::Active Lattice::children(const Active &active, const std::array<bool, kAxes> &split) {
    Level level = levels_.back();
    for (size_t axis = 0; axis < kAxes; axis++)
        level.counts[axis] *= split[axis] ? 2 : 1;
    levels_.push_back(level);
    Active made;
    for (const Cell &parent : active) {
        Cell child = parent;
        child.level = static_cast<int32_t>(levels_.size()) - 1;
        for (size_t part = 0; part < (size_t{1} << kAxes); part++) {
            bool is_child = true;
            for (size_t axis = 0; axis < kAxes; axis++) {
                const auto second = static_cast<int32_t>(part >> axis & 1);
                is_child = is_child && (split[axis] || second == 0);
                child.place[axis] = split[axis] ? 2 * parent.place[axis] + second : parent.place[axis];
            }
            if (is_child)
                made.push_back(child);
        }
    }
    std::sort(made.begin(), made.end(), before);
    return made;
}

Node Lattice::node(const Cell &cell, const std::array<double, kAxes> &part) const noexcept {
    const Level &level = levels_[static_cast<size_t>(cell.level)];
    const Prior &prior = problem_.prior;
    const auto share = [&](size_t axis) { return (cell.place[axis] + part[axis]) / level.counts[axis]; };
    return {{prior.frequency_min + (prior.frequency_max - prior.frequency_min) * share(kFrequency),
             prior.eccentricity(share(kEccentricity)), share(kAnomaly)},
            prior.jitter(share(kJitter))};
}

const Design &Lattice::design(int32_t count, int32_t place) const {
    return *designs_.at({count, place});
}

const Design &Lattice::design(const Cell &cell) const {
    return design(levels_[static_cast<size_t>(cell.level)].counts[kJitter], cell.place[kJitter]);
}

} // namespace toliman::planet
