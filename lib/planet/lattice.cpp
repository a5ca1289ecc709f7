// Method: midpoint rule on a lattice of cells in frequency (steps of a fifth of 1/span), (1 - e)^0.4, and mean anomaly;
// at each node the jitter is integrated (jitter.cpp). In turns, each axis in which the logarithm of neighbouring nodes
// differs by more than 0.6, as the rms over the posterior, is halved: in a Gaussian posterior, cells are then smaller
// than 0.6 of its conditional standard deviation. Only cells are divided whose logarithm is within 8 of the largest,
// plus half of the differences from their neighbours: more than the logarithm may rise inside a cell around a peak.
// So the limit is wide for strong signals at first, and follows their peak down to widths of 1e-5 cells. A peak may
// leave the divided cells, as the short passages of eccentric orbits fall between the first nodes: while all cells that
// may contain it were divided, the neighbours of cells within 8 of the largest are added where a division has none, in
// turns. All other cells keep their mass. Long ranges of frequency are several boxes, of which only those are divided
// that may contain a part of the posterior: the memory is bounded, and the time is that of the first nodes. Nodes are
// independent of each other and sums are taken in the order of the cells, so that the threads do not change a bit.
//
// Rejected: Markov chains, whose convergence needs a judgement; refining around the highest node only, which loses the
// weaker of two periods.
// Reference: Price-Whelan et al. (2017), ApJ 837, 20, sample the same posterior at random
#include "planet/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "base/error.hpp"
#include "base/workers.hpp"

namespace toliman::planet {

namespace {

constexpr double kMostDifference = 0.6; // rms of neighbouring logarithms over the posterior
constexpr double kLogCut = 8;           // of logarithms, below the largest
constexpr double kRise = 0.5;           // of the differences from the neighbours: the rise inside a cell
constexpr double kFrequencyStep = 0.2;  // of 1/span
constexpr int32_t kEccentricities = 10, kAnomalies = 16;
constexpr int32_t kBoxCells = 16;
constexpr double kBoxErrors = 8, kCellPower = 0.4;
constexpr size_t kMostCells = 4'000'000, kMostRefined = 1'000'000, kCellsAtOnce = 256;
constexpr size_t kLeastRefined = 4096;    // of a level, when kMostWork is reached
constexpr size_t kMostWork = 400'000'000; // refined cells times measurements: about 5 s of one processor
constexpr size_t kScaleWork = 8;          // of a scale of the amplitudes, in measurements
constexpr size_t kJitterWork = 4;         // of an integral over the jitter, in nodes without one
constexpr double kOrder = 3;             // error of the midpoint rule after a division, of the change by it: 1/4 to 3/4
constexpr double kNegligible = 40;       // of logarithms, below the largest: cells that are not kept
constexpr double kMostFrequencies = 2e6; // of frequency: minutes of one processor
constexpr int kMostLevels = 100;
constexpr size_t kMostPeaks = 24, kHighCells = 4096; // peaks are searched among the highest cells
constexpr int32_t kMostCount = 1 << 29;

size_t cell_count(const Box &box) noexcept {
    size_t count = 1;
    for (const int32_t n : box.counts)
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
    Neighbours(const std::vector<Cell> &active, const Box &level, size_t axis, int direction) noexcept
        : active_(active), count_(level.counts[axis]), axis_(axis), direction_(direction), next_(active.end()),
          is_circle_(axis == kAnomaly && level.is_circle) {}

    // The place of the neighbour of a cell; none at an end of the axis.
    std::optional<Place> place_of(const Cell &cell) const noexcept {
        Place at = cell.place;
        at[axis_] += direction_;
        if (is_circle_)
            at[axis_] = (at[axis_] + count_) % count_;
        return at[axis_] >= 0 && at[axis_] < count_ ? std::optional(at) : std::nullopt;
    }

    // The neighbour of a cell, which is not before that of the last call; NULL if there is none.
    const Cell *of(const Cell &cell) noexcept {
        const std::optional<Place> place = place_of(cell);
        if (!place)
            return nullptr;
        Cell at = cell;
        at.place = *place;
        const bool is_around = at.place[axis_] - cell.place[axis_] != direction_;
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
std::vector<Cell> all_cells(const Box &level) {
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
void add_differences(const std::vector<Cell> &active, const Box &level, size_t axis, size_t first, size_t end,
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

Roughness roughness(const std::vector<Cell> &active, const Box &level, unsigned threads) {
    Roughness rough;
    rough.each.resize(active.size());
    const double largest = active[highest(active)].log_mass;
    std::vector<Sums> parts((active.size() + kCellsAtOnce - 1) / kCellsAtOnce);
    run_jobs(worker_count(threads), parts.size(), [&](size_t part) {
        for (size_t axis = 0; axis < kAxes; axis++)
            if (level.counts[axis] > 1)
                add_differences(active, level, axis, part * kCellsAtOnce,
                                std::min(active.size(), (part + 1) * kCellsAtOnce), largest, parts[part], rough.each);
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
std::array<bool, kAxes> axes_to_split(const Roughness &rough, const Box &level) {
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
    const double largest = active[highest(active)].log_mass, wanted = largest - kLogCut;
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

bool has_no_higher_neighbour(const std::vector<Cell> &active, const Box &level, const Cell &cell) {
    for (size_t axis = 0; axis < kAxes; axis++)
        for (const int direction : {-1, 1}) {
            const Cell *const next = Neighbours(active, level, axis, direction).of(cell);
            if (next != nullptr && next->log_mass > cell.log_mass)
                return false;
        }
    return true;
}

// The neighbours of the highest cells that are not among the cells, in order, with the masses of these highest cells.
std::vector<Cell> missing_neighbours(const std::vector<Cell> &active, const Box &level) {
    const double least = active[highest(active)].log_mass - kLogCut;
    std::vector<Cell> missing;
    for (size_t axis = 0; axis < kAxes; axis++)
        for (const int direction : {-1, 1}) {
            Neighbours neighbours(active, level, axis, direction);
            for (const Cell &cell : active)
                if (cell.log_mass >= least && neighbours.of(cell) == nullptr)
                    if (const std::optional<Place> place = neighbours.place_of(cell)) {
                        missing.push_back(cell);
                        missing.back().place = *place;
                    }
        }
    std::sort(missing.begin(), missing.end(), before);
    const auto is_same = [](const Cell &a, const Cell &b) { return a.place == b.place; };
    missing.erase(std::unique(missing.begin(), missing.end(), is_same), missing.end());
    return missing;
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

// The lower end of a cell of the eccentricity. Cells are equal in (1 - e)^0.4: those of high eccentricities are small,
// as their orbits differ by more.
double eccentricity_end(const Box &box, int32_t cell) noexcept {
    const int32_t count = box.counts[kEccentricity];
    const double first = std::pow(1 - box.low[kEccentricity], kCellPower);
    const double last = std::pow(1 - box.high[kEccentricity], kCellPower);
    return cell == count ? box.high[kEccentricity]
                         : 1 - std::pow(first + (last - first) * cell / count, 1 / kCellPower);
}

// The highest logarithm that a cell may reach inside.
double highest_inside(const std::vector<Cell> &cells, const Roughness &rough) noexcept {
    double most = -HUGE_VAL;
    for (size_t i = 0; i < cells.size(); i++)
        most = std::max(most, cells[i].log_mass + kRise * rough.each[i]);
    return most;
}

} // namespace

std::vector<Box> whole_boxes(const Problem &problem) {
    const Prior &prior = problem.prior;
    const double steps =
        std::max(4.0, std::ceil((prior.frequency_max - prior.frequency_min) * problem.series.span / kFrequencyStep));
    if (!(steps < kMostFrequencies))
        fail(Status::range,
             "{options->prior.period_min} = %.9g: too short for the span of the series, %.9g: %.3g steps of frequency, "
             "at most %.3g",
             1 / prior.frequency_max, problem.series.span, steps, kMostFrequencies);
    const auto most = static_cast<double>(kMostCells / (kEccentricities * kAnomalies));
    const auto count = static_cast<size_t>(std::ceil(steps / most));
    const double each = std::ceil(steps / static_cast<double>(count)),
                 range = prior.frequency_max - prior.frequency_min;
    std::vector<Box> boxes;
    for (size_t i = 0; i < count; i++) {
        const auto at = [&](size_t end) {
            return end == count ? prior.frequency_max
                                : prior.frequency_min + range * static_cast<double>(end) / static_cast<double>(count);
        };
        boxes.push_back({{0, at(i), 0},
                         {prior.eccentricity_max, at(i + 1), 1},
                         {kEccentricities, static_cast<int32_t>(each), kAnomalies}});
    }
    return boxes;
}

Box box_around(const Problem &problem, const Orbit &orbit, const Orbit &error) {
    const Prior &prior = problem.prior;
    Box box = {{std::max(0.0, orbit.eccentricity - kBoxErrors * error.eccentricity),
                std::max(prior.frequency_min, orbit.frequency - kBoxErrors * error.frequency), 0},
               {std::min(prior.eccentricity_max, orbit.eccentricity + kBoxErrors * error.eccentricity),
                std::min(prior.frequency_max, orbit.frequency + kBoxErrors * error.frequency), 1},
               {kBoxCells, kBoxCells, kBoxCells}};
    if (kBoxErrors * error.anomaly < 0.5) {
        box.low[kAnomaly] = orbit.anomaly - kBoxErrors * error.anomaly;
        box.high[kAnomaly] = orbit.anomaly + kBoxErrors * error.anomaly;
        box.is_circle = false;
    }
    return box;
}

Lattice::Lattice(const Problem &problem, const std::vector<Box> &boxes, unsigned threads, const Progress &progress,
                 const char *stage)
    : problem_(problem), log_rest_(-HUGE_VAL), log_left_over_(-HUGE_VAL), jitters_(problem) {
    const size_t work = problem_.series.rows + kScaleWork * problem_.prior.scales.size();
    size_t left = kMostWork / (work * (jitters_.count() > 1 ? kJitterWork : 1));
    const Run run = {threads, progress, stage};
    const auto count = static_cast<double>(boxes.size());
    const bool are_several = boxes.size() > 1;
    std::vector<double> peaks(boxes.size(), HUGE_VAL), sums(boxes.size());
    double largest = -HUGE_VAL;
    for (size_t i = 0; i < boxes.size() && are_several; i++) {
        Active active = first_cells(boxes[i]);
        evaluate(active, run, static_cast<double>(i) / count / 2, static_cast<double>(i + 1) / count / 2);
        peaks[i] = highest_inside(active, roughness(active, boxes[i], threads));
        sums[i] = log_sum(active);
        largest = std::max(largest, active[highest(active)].log_mass);
        levels_.clear();
    }
    const double begin = are_several ? 0.5 : 0;
    for (size_t i = 0; i < boxes.size(); i++) {
        const double from = begin + (1 - begin) * static_cast<double>(i) / count, to = from + (1 - begin) / count;
        if (peaks[i] < largest - kLogCut) {
            log_rest_ = log_add(log_rest_, sums[i]);
            continue;
        }
        refine(first_cells(boxes[i]), run, from, to, left);
        if (are_several)
            drop_negligible();
    }
    progress.report(stage, 1);
    best_ = highest(cells_);
    log_evidence_ = log_add(log_sum(cells_), log_rest_);
    log_error_ += std::log1p(std::exp(log_left_over_ - log_evidence_));
}

Lattice::Active Lattice::first_cells(const Box &box) {
    levels_.push_back(box);
    Active cells = all_cells(box);
    for (Cell &cell : cells)
        cell.level = static_cast<int32_t>(levels_.size()) - 1;
    return cells;
}

void Lattice::refine(Active active, const Run &run, double from, double to, size_t &left) {
    double done = from, sum = NAN;
    bool is_whole = true; // no cells were too many: neighbours that are missing lie in cells of little mass
    for (int turn = 0;; turn++) {
        const double next = (to + done) / 2, before = sum;
        evaluate(active, run, done, next);
        if (is_whole)
            grow(active, run, next, left);
        done = next;
        sum = cells_.empty() ? log_sum(active) : log_add(log_sum(cells_), log_sum(active));
        if (turn == 0)
            keep_peaks(active);
        const Box &level = levels_.back();
        const Roughness rough = roughness(active, level, run.threads);
        const std::array<bool, kAxes> split = axes_to_split(rough, level);
        const auto axes = std::count(split.begin(), split.end(), true);
        const size_t most = std::clamp(left, kLeastRefined, kMostRefined) >> axes;
        const Division division = divide(active, rough, most);
        const bool ends = axes == 0 || turn + 1 == kMostLevels;
        if (!ends) {
            log_left_over_ = log_add(log_left_over_, division.log_left);
            is_whole = is_whole && std::isinf(division.log_left);
        }
        Active kept;
        for (size_t i = 0; i < active.size(); i++)
            (division.is_split[i] && !ends ? kept : cells_).push_back(active[i]);
        if (kept.empty()) {
            const double error = (turn == 0 ? difference_of_halves(active) : std::fabs(sum - before)) / kOrder;
            log_error_ = std::max(log_error_, error);
            break;
        }
        active = children(kept, split);
        left -= std::min(left, active.size());
    }
}

void Lattice::keep_peaks(const Active &active) {
    const auto is_higher = [](const Cell &a, const Cell &b) { return a.log_mass > b.log_mass; };
    Active high(std::min(kHighCells, active.size()));
    std::partial_sort_copy(active.begin(), active.end(), high.begin(), high.end(), is_higher);
    for (const Cell &cell : high)
        if (has_no_higher_neighbour(active, levels_.back(), cell))
            peaks_.push_back(cell);
    std::sort(peaks_.begin(), peaks_.end(), is_higher);
    peaks_.resize(std::min(kMostPeaks, peaks_.size()));
}

std::vector<Orbit> Lattice::peaks() const {
    std::vector<Orbit> orbits;
    for (const Cell &cell : peaks_)
        orbits.push_back(orbit(cell, {0.5, 0.5, 0.5}));
    return orbits;
}

// Adds cells to the rest that no sample is drawn from.
void Lattice::drop_negligible() {
    const double least = cells_[highest(cells_)].log_mass - kNegligible;
    const auto is_negligible = [&](const Cell &cell) { return cell.log_mass < least; };
    for (const Cell &cell : cells_)
        if (is_negligible(cell))
            log_rest_ = log_add(log_rest_, cell.log_mass);
    cells_.erase(std::remove_if(cells_.begin(), cells_.end(), is_negligible), cells_.end());
}

void Lattice::grow(Active &active, const Run &run, double at, size_t &left) {
    for (;;) {
        Active next = missing_neighbours(active, levels_.back());
        if (next.empty())
            break;
        if (next.size() > left) {
            log_left_over_ = log_add(log_left_over_, log_sum(next));
            break;
        }
        evaluate(next, run, at, at);
        left -= next.size();
        const auto middle = active.insert(active.end(), next.begin(), next.end());
        std::inplace_merge(active.begin(), middle, active.end(), before);
    }
}

void Lattice::evaluate(Active &active, const Run &run, double from, double to) {
    const Box &level = levels_.back();
    const Prior &prior = problem_.prior;
    const auto width = [&](Axis axis) { return (level.high[axis] - level.low[axis]) / level.counts[axis]; };
    const double step = width(kFrequency), others = std::log(width(kAnomaly));
    const size_t chunks = (active.size() + kCellsAtOnce - 1) / kCellsAtOnce;
    run_jobs(
        worker_count(run.threads), chunks,
        [&](size_t chunk) {
            ShapeWork work(problem_.series);
            double eccentricity = 0, log_share = 0;
            int32_t known = -1; // place of `eccentricity`
            size_t jitter = jitters_.null().best;
            const size_t end = std::min(active.size(), (chunk + 1) * kCellsAtOnce);
            for (size_t i = chunk * kCellsAtOnce; i < end; i++) {
                Cell &cell = active[i];
                const Place &place = cell.place;
                if (place[kEccentricity] != known) {
                    known = place[kEccentricity];
                    const double from_e = eccentricity_end(level, known), to_e = eccentricity_end(level, known + 1);
                    eccentricity = prior.eccentricity_in(from_e, to_e, 0.5);
                    log_share = std::log(prior.eccentricity_share(from_e, to_e));
                }
                const double low = level.low[kFrequency] + step * place[kFrequency];
                const Orbit orbit = {low + step / 2, eccentricity,
                                     level.low[kAnomaly] + (place[kAnomaly] + 0.5) * width(kAnomaly), problem_.star};
                const JitterIntegral integral = jitters_.at(work, orbit, jitter);
                jitter = integral.best;
                cell.jitter = static_cast<uint32_t>(jitter);
                cell.log_mass = integral.log_sum + std::log(prior.share(low, low + step)) + log_share + others;
            }
        },
        [&](double part) { run.progress.report(run.stage, from + (to - from) * part); });
}

Lattice::Active Lattice::children(const Active &active, const std::array<bool, kAxes> &split) {
    Box level = levels_.back();
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

Orbit Lattice::orbit(const Cell &cell, const std::array<double, kAxes> &part) const noexcept {
    const Box &level = levels_[static_cast<size_t>(cell.level)];
    const auto at = [&](size_t axis) {
        return level.low[axis] +
               (level.high[axis] - level.low[axis]) * (cell.place[axis] + part[axis]) / level.counts[axis];
    };
    const int32_t place = cell.place[kEccentricity];
    return {at(kFrequency),
            problem_.prior.eccentricity_in(std::max(0.0, eccentricity_end(level, place)),
                                           eccentricity_end(level, place + 1), part[kEccentricity]),
            at(kAnomaly), problem_.star};
}

} // namespace toliman::planet
