// Method: two tests of the residuals r (over their standard deviations, white if the model is right).
//   chi-square   the mean of r^2, against 6 standard deviations on both sides of 1: base/goodness.cpp
//   structure    for each neighbour d of (0,1), (1,0), (1,1), (1,-1), (0,2), (2,0): z_d = sum of r(p) r(p + d) over all
//                pixels p of all frames, over the square root of the number of pairs. The sum of z_d^2 is chi-square
//                distributed with 6 degrees of freedom: 50 is exceeded once in 2e8 calibrations. Patterns of the
//                width of a fringe that are far below the noise of a pixel add up.
// A map also fits some of the noise, and the sum of r^2 falls. The effective number of its parameters in one step
// (map.cpp) is subtracted from the degrees of freedom. All steps together fit at most twice as much: the lower limit of
// chi-square is lowered by as much again. With the relative loss 1 - (sum of r^2)/pixels of the power, the sum of z_d^2
// grows by 0.2 to 0.4 times pixels times its square (measured); a limit that is larger by once this product allows for
// it. Whether the instrument changes with time: by how much the first step to values that are linear in time would
// lower the sum of r^2, against 6 standard deviations of what noise explains (Rao 1948, Math. Proc.
// Cambridge 44, 50: score test), of variances that are multiplied by chi-square; and its share of what is not noise, as
// the pointing changes with time, too, and with it the residuals of other effects. Windows that are not enough may
// always be too long, as the image is linear between their starts, also where its change is not.
// Reference: Box and Pierce 1970, J. Am. Stat. Assoc. 65, 1509, here in two dimensions.
#include "calibrate/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "base/robust.hpp"
#include "calibrate/prior.hpp"

namespace toliman::calibrate {

namespace {

struct Neighbour {
    size_t down;
    long right;
};
constexpr Neighbour kNeighbours[] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}, {0, 2}, {2, 0}};
constexpr size_t kNeighbourCount = std::size(kNeighbours);

struct Correlation {
    double sum[kNeighbourCount] = {};
    double pairs[kNeighbourCount] = {};

    void add(const double *residual, size_t rows, size_t cols) noexcept {
        for (size_t n = 0; n < kNeighbourCount && cols > 2; n++) {
            const auto [down, right] = kNeighbours[n];
            const size_t first = right < 0 ? static_cast<size_t>(-right) : 0,
                         last = right > 0 ? cols - static_cast<size_t>(right) : cols;
            for (size_t y = 0; y + down < rows; y++) {
                const double *const one = residual + y * cols, *const other = residual + (y + down) * cols + right;
                for (size_t x = first; x < last; x++) {
                    sum[n] += one[x] * other[x];
                    pairs[n] += one[x] != 0 && other[x] != 0 ? 1 : 0;
                }
            }
        }
    }
    double structure() const noexcept {
        double total = 0;
        for (size_t n = 0; n < kNeighbourCount; n++)
            total += pairs[n] > 0 ? sum[n] * sum[n] / pairs[n] : 0;
        return total;
    }
};

// Whitened residuals of some frames together.
struct Residuals {
    double squares = 0, inverse_counts = 0, largest = 0;
    double freedom = 0; // pixels minus the frames' own parameters
    size_t used = 0;    // pixels

    void add(const Block &block) noexcept {
        squares += block.chi_square;
        inverse_counts += block.inverse_counts;
        used += block.used;
        freedom += static_cast<double>(block.used) - static_cast<double>(kOwn);
    }
    void add(const Residuals &other) noexcept {
        squares += other.squares;
        inverse_counts += other.inverse_counts;
        largest = std::max(largest, other.largest);
        used += other.used;
        freedom += other.freedom;
    }
    // After a fit of this many further parameters, and of a map.
    Goodness judged(double parameters, double of_map) const noexcept {
        const double left = freedom - parameters - of_map, sigma = chi_square_sigma(used, inverse_counts, left);
        Goodness goodness = goodness_of(squares / left, sigma, largest, kFrameSigmas);
        const double lowest = chi_square_quantile(sigma, -kFrameSigmas) - of_map / left;
        if (goodness.verdict == GoodnessVerdict::too_good && goodness.chi_square >= lowest)
            goodness.verdict = GoodnessVerdict::good;
        return goodness;
    }
};

// Results of the frames of a window, with both uncertainties of their separation.
void describe_frames(const Joint &joint, const Problem &problem, const Point &point, const Linearisation &normal,
                     Calibration &out, std::vector<double> &alone, std::vector<double> &added) {
    for (const size_t frame : joint.frames()) {
        fit::Result &result = out.frames[frame], known;
        const Block &block = normal.blocks[frame];
        const std::shared_ptr<const fit::Fit> fit = joint.fit_of(frame);
        const fit::Fit::Start start = fit->start_of(problem.frames.predictions[frame]);
        fit->describe(point.own[frame].data(), out.uncertainty.alone[frame].data(), known);
        fit->describe(point.own[frame].data(), out.uncertainty.whole[frame].data(), result);
        result.displacement_px = result.values[0] - start.separation_px;
        const auto pixels = static_cast<double>(block.used);
        const double freedom = pixels - static_cast<double>(kOwn);
        result.goodness =
            frame_goodness(block.chi_square / freedom, chi_square_sigma(block.used, block.inverse_counts, freedom), NAN,
                           point.bad_of(frame).count(), true);
        result.bad = point.bad_of(frame);
        result.excluded = block.saturated;
        if (block.saturated > 0)
            result.flags |= fit::saturated;
        alone.push_back(std::sqrt(known.covariance[0]));
        added.push_back(std::sqrt(std::max(0.0, result.covariance[0] - known.covariance[0])));
    }
}

double drift_of(Problem problem, Point point, const Linearisation &normal) {
    const std::vector<Window> before = problem.windows;
    if (!refine_windows(problem))
        return 0;
    if (before.size() > 1)
        return 1;
    point.instrument = at_starts(point.instrument, before, problem.windows);
    const auto added = static_cast<double>((problem.windows.size() - before.size()) * problem.free.size());
    const double noise = added * chi_square_quantile(std::sqrt(2 / added), kFrameSigmas),
                 gain = gain_of_step(problem, point, normal),
                 unexplained = static_cast<double>(normal.used) * (1 - 1 / normal.excess);
    return gain > noise ? gain / std::max(gain, unexplained) : 0;
}

} // namespace

Buffer<double> whitened_frame(const Problem &problem, const Point &point, size_t frame) {
    Buffer<double> image;
    for (size_t window = 0; window < problem.windows.size(); window++) {
        const std::vector<size_t> &frames = problem.windows[window].frames;
        if (std::find(frames.begin(), frames.end(), frame) == frames.end())
            continue;
        const Joint joint(problem, point, window);
        const size_t pixels = problem.nominal.detector.rows * problem.nominal.detector.cols;
        joint.whiten({frame}, [&](const Whitened &whitened) {
            image.resize(pixels);
            std::copy_n(whitened.residual, pixels, image.data());
        });
    }
    return image;
}

void judge(const Problem &problem, const Point &point, const Linearisation &normal, Calibration &out) {
    out.point = point;
    out.uncertainty = uncertainty_of(problem, normal);
    if (!out.uncertainty.solvable) {
        out.flags = not_converged;
        return;
    }
    const size_t rows = problem.nominal.detector.rows, cols = problem.nominal.detector.cols, n = problem.free.size(),
                 size = n * problem.windows.size();
    const double determined = static_cast<double>(size) + out.response_parameters; // a response has one window
    out.frames.assign(problem.frames.count, {});
    out.chi_map.resize(rows * cols);
    std::vector<double> alone, added;
    Correlation correlation;
    Residuals all;
    Buffer<double> counted(rows * cols);
    std::unique_ptr<Joint> joint;
    for (size_t window = 0; window < problem.windows.size(); window++) {
        joint = std::make_unique<Joint>(problem, point, window, joint.get());
        describe_frames(*joint, problem, point, normal, out, alone, added);
        Residuals residuals;
        joint->whiten(problem.windows[window].frames, [&](const Whitened &whitened) {
            correlation.add(whitened.residual, rows, cols);
            for (size_t i = 0; i < rows * cols; i++) {
                residuals.largest = std::max(residuals.largest, std::fabs(whitened.residual[i]));
                out.chi_map[i] += whitened.residual[i] * whitened.residual[i];
                counted[i] += whitened.residual[i] != 0 ? 1 : 0;
            }
            if (whitened.frame == 0) {
                out.after.resize(rows * cols);
                std::copy_n(whitened.residual, rows * cols, out.after.data());
            }
            residuals.add(normal.blocks[whitened.frame]);
        });
        const double share =
            static_cast<double>(problem.windows[window].frames.size()) / static_cast<double>(problem.frames.count);
        const bool is_seen = residuals.used > 0 || window == 0;
        out.goodness_of.push_back(
            is_seen ? residuals.judged(static_cast<double>(n) + out.response_parameters, share * out.map_parameters)
                    : out.goodness_of.back());
        all.add(residuals);
    }
    for (size_t i = 0; i < rows * cols; i++)
        out.chi_map[i] /= std::max(1.0, counted[i]);
    out.separation_sigma_px = median(alone);
    out.calibration_sigma_px = normal.of_response.empty() ? median(added) : normal.separation_sigma_px;
    out.structure = correlation.structure();
    out.goodness = all.judged(determined, out.map_parameters);
    out.squares = all.squares;
    out.freedom = all.freedom - determined - out.map_parameters;
    const double loss = std::max(0.0, 1 - all.squares / (all.freedom - determined));
    out.structure_limit = kStructureLimit + (point.map_m.empty() ? 0 : static_cast<double>(all.used) * loss * loss);
    const auto is = [&](GoodnessVerdict verdict) {
        return out.goodness.verdict == verdict ||
               std::any_of(out.goodness_of.begin(), out.goodness_of.end(),
                           [=](const Goodness &of) { return of.verdict == verdict; });
    };
    if (is(GoodnessVerdict::poor) || out.structure > out.structure_limit)
        out.flags |= incomplete;
    if ((out.flags & incomplete) != 0 && point.response.empty())
        out.drift = drift_of(problem, point, normal);
    if (is(GoodnessVerdict::too_good))
        out.flags |= too_good;
    for (size_t i = 0; i < size; i++) {
        const double sigma = std::sqrt(out.uncertainty.instrument[i * size + i]);
        if (sigma > kHeld * problem.free[i % n].sigma)
            out.flags |= held;
    }
    if (std::find(out.even.begin(), out.even.end(), true) != out.even.end())
        out.flags |= no_sign;
}

} // namespace toliman::calibrate
