// Method: midpoint rule on a lattice of cells in frequency (steps of a fifth of 1/span), (1 - e)^0.4, and mean anomaly;
// at each node the jitter is integrated (jitter.cpp). In turns, each axis in which the logarithm of neighbouring nodes
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
constexpr int32_t kEccentricities = 10, kAnomalies = 16;
constexpr int32_t kBoxCells = 16;
constexpr double kBoxErrors = 8, kCellPower = 0.4;
constexpr size_t kMostCells = 20'000'000, kMostRefined = 1'000'000, kChunk = 256;
constexpr size_t kLeastRefined = 4096;    // of a level, when kMostWork is reached
constexpr size_t kMostWork = 400'000'000; // refined cells times measurements: about 5 s of one processor
constexpr size_t kScaleWork = 8;          // of a scale of the amplitudes, in measurements
constexpr size_t kJitterWork = 4;         // of an integral over the jitter, in nodes without one
constexpr double kOrder = 3; // error of the midpoint rule after a division, of the change by it: 1/4 to 3/4
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
        : active_(active), count_(level.counts[axis]), axis_(axis), direction_(direction), next_(active.end()),
          is_circle_(axis == kAnomaly && level.is_circle) {}

    // The neighbour of a cell, which is not before that of the last call; NULL if there is none.
    const Cell *of(const Cell &cell) noexcept {
        Cell at = cell;
        at.place[axis_] += direction_;
        const bool is_around = is_circle_ && (at.place[axis_] < 0 || at.place[axis_] == count_);
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
    bool is_circle_;
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

double log_add(double a, double b) noexcept {
    const double largest = std::max(a, b);
    return std::isinf(largest) ? largest : largest + std::log(std::exp(a - largest) + std::exp(b - largest));
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

// Which cells are divided: those that may contain a part of the posterior, and at most `most` of them; and ln of the
// mass of those that are too many.
struct Division {
    std::vector<bool> is_split;
    double log_left = -HUGE_VAL;
};

Division divide(const std::vector<Cell> &active, const Roughness &rough, size_t most) {
    std::vector<double> highest_inside(active.size());
    for (size_t i = 0; i < active.size(); i++)
        highest_inside[i] = active[i].log_mass + kRise * rough.each[i];
    const double largest = active[highest(active)].log_mass, wanted = largest - kCut;
    double least = wanted;
    if (active.size() > most) {
        std::vector<double> sorted = highest_inside;
        const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(most);
        std::nth_element(sorted.begin(), place, sorted.end(), std::greater<>());
        least = std::max(least, std::nextafter(*place, HUGE_VAL));
    }
    Division division;
    division.is_split.resize(active.size());
    double left = 0;
    for (size_t i = 0; i < active.size(); i++) {
        division.is_split[i] = highest_inside[i] >= least;
        if (!division.is_split[i] && highest_inside[i] >= wanted)
            left += std::exp(active[i].log_mass - largest);
    }
    division.log_left = largest + std::log(left);
    return division;
}

// The larger change of ln of the evidence if only every second cell is used, in frequency or in anomaly.
double difference_of_halves(const std::vector<Cell> &cells) noexcept {
    const double largest = cells[highest(cells)].log_mass;
    double most = 0;
    for (const Axis axis : {kFrequency, kAnomaly}) {
        double half = 0, all = 0;
        for (const Cell &cell : cells) {
            const double mass = std::exp(cell.log_mass - largest);
            half += cell.place[axis] % 2 == 0 ? mass : 0;
            all += mass;
        }
        most = std::max(most, std::fabs(std::log(2 * half / all)));
    }
    return most;
}

} // namespace

Box whole_box(const Problem &problem) {
    const Prior &prior = problem.prior;
    const double steps = (prior.frequency_max - prior.frequency_min) * problem.series.span / kFrequencyStep;
    if (!(steps < static_cast<double>(kMostCells)))
        fail(Status::range, "{options->period_min} = %.9g: too short for the span of the series: %.3g frequencies",
             1 / prior.frequency_max, steps);
    const Level level = {{kEccentricities, std::max(4, static_cast<int32_t>(std::ceil(steps))), kAnomalies}, true};
    if (cell_count(level) > kMostCells)
        fail(Status::range,
             "{options->period_min} = %.9g: too short for the span of the series: %zu nodes, at most %zu",
             1 / prior.frequency_max, cell_count(level), kMostCells);
    return {{0, prior.frequency_min, 0}, {prior.eccentricity_max, prior.frequency_max, 1}, level};
}

Box box_around(const Problem &problem, const Orbit &orbit, const Orbit &error) {
    const Prior &prior = problem.prior;
    Box box = {{std::max(0.0, orbit.eccentricity - kBoxErrors * error.eccentricity),
                std::max(prior.frequency_min, orbit.frequency - kBoxErrors * error.frequency), 0},
               {std::min(prior.eccentricity_max, orbit.eccentricity + kBoxErrors * error.eccentricity),
                std::min(prior.frequency_max, orbit.frequency + kBoxErrors * error.frequency), 1},
               {{kBoxCells, kBoxCells, kBoxCells}, true}};
    if (kBoxErrors * error.anomaly < 0.5) {
        box.low[kAnomaly] = orbit.anomaly - kBoxErrors * error.anomaly;
        box.high[kAnomaly] = orbit.anomaly + kBoxErrors * error.anomaly;
        box.level.is_circle = false;
    }
    return box;
}

Lattice::Lattice(const Problem &problem, const Box &box, unsigned threads, const Progress &progress, const char *stage)
    : problem_(problem), box_(box), stage_(stage), levels_{box.level}, jitters_(problem) {
    Active active = all_cells(levels_.back());
    double done = 0, before = NAN, left_over = -HUGE_VAL;
    const size_t work = problem_.series.rows + kScaleWork * problem_.prior.scales.size();
    size_t left = kMostWork / (work * (jitters_.count() > 1 ? kJitterWork : 1));
    for (int turn = 0;; turn++) {
        const double next = turn == 0 ? 0.5 : (1 + done) / 2;
        evaluate(active, threads, progress, done, next);
        done = next;
        before = log_evidence_;
        log_evidence_ = cells_.empty() ? log_sum(active) : log_add(log_sum(cells_), log_sum(active));
        const Level &level = levels_.back();
        const Roughness rough = roughness(active, level, threads);
        const std::array<bool, kAxes> split = axes_to_split(rough, level);
        const auto axes = std::count(split.begin(), split.end(), true);
        const size_t most = std::clamp(left, kLeastRefined, kMostRefined) >> axes;
        const Division division = divide(active, rough, most);
        const bool ends = axes == 0 || turn + 1 == kMostLevels;
        if (!ends)
            left_over = log_add(left_over, division.log_left);
        Active kept;
        for (size_t i = 0; i < active.size(); i++)
            (division.is_split[i] && !ends ? kept : cells_).push_back(active[i]);
        if (kept.empty()) {
            log_error_ = (turn == 0 ? difference_of_halves(active) : std::fabs(log_evidence_ - before)) / kOrder;
            break;
        }
        active = children(kept, split);
        left -= std::min(left, active.size());
    }
    progress.report(stage, 1);
    best_ = highest(cells_);
    log_evidence_ = log_sum(cells_);
    log_error_ += std::log1p(std::exp(left_over - log_evidence_));
}

void Lattice::evaluate(Active &active, unsigned threads, const Progress &progress, double from, double to) {
    const Level &level = levels_.back();
    const Prior &prior = problem_.prior;
    const auto width = [&](Axis axis) { return (box_.high[axis] - box_.low[axis]) / level.counts[axis]; };
    const double step = width(kFrequency), others = std::log(width(kAnomaly));
    const size_t chunks = (active.size() + kChunk - 1) / kChunk;
    run_jobs(
        worker_count(threads), chunks,
        [&](size_t chunk) {
            ShapeWork work(problem_.series);
            double eccentricity = 0, log_share = 0;
            int32_t known = -1; // place of `eccentricity`
            size_t jitter = jitters_.null().best;
            const size_t end = std::min(active.size(), (chunk + 1) * kChunk);
            for (size_t i = chunk * kChunk; i < end; i++) {
                Cell &cell = active[i];
                const Place &place = cell.place;
                if (place[kEccentricity] != known) {
                    known = place[kEccentricity];
                    const double from_e = eccentricity_end(known, level.counts[kEccentricity]);
                    const double to_e = eccentricity_end(known + 1, level.counts[kEccentricity]);
                    eccentricity = prior.eccentricity_in(from_e, to_e, 0.5);
                    log_share = std::log(prior.eccentricity_share(from_e, to_e));
                }
                const double low = box_.low[kFrequency] + step * place[kFrequency];
                const Orbit orbit = {low + step / 2, eccentricity,
                                     box_.low[kAnomaly] + (place[kAnomaly] + 0.5) * width(kAnomaly)};
                const JitterIntegral integral = jitters_.at(work, orbit, jitter);
                jitter = integral.best;
                cell.jitter = static_cast<uint32_t>(jitter);
                cell.log_mass = integral.log_sum + std::log(prior.share(low, low + step)) + log_share + others;
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

// Cells are equal in (1 - e)^0.4: those of high eccentricities are small, as their orbits differ by more.
double Lattice::eccentricity_end(int32_t cell, int32_t count) const noexcept {
    const double first = std::pow(1 - box_.low[kEccentricity], kCellPower);
    const double last = std::pow(1 - box_.high[kEccentricity], kCellPower);
    return cell == count ? box_.high[kEccentricity]
                         : 1 - std::pow(first + (last - first) * cell / count, 1 / kCellPower);
}

Orbit Lattice::orbit(const Cell &cell, const std::array<double, kAxes> &part) const noexcept {
    const Level &level = levels_[static_cast<size_t>(cell.level)];
    const auto at = [&](size_t axis) {
        return box_.low[axis] +
               (box_.high[axis] - box_.low[axis]) * (cell.place[axis] + part[axis]) / level.counts[axis];
    };
    const int32_t place = cell.place[kEccentricity], count = level.counts[kEccentricity];
    return {at(kFrequency),
            problem_.prior.eccentricity_in(std::max(0.0, eccentricity_end(place, count)),
                                           eccentricity_end(place + 1, count), part[kEccentricity]),
            at(kAnomaly)};
}

} // namespace toliman::planet
