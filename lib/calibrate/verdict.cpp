// Method: two tests of the residuals r (over their standard deviations, white if the model is right).
//   chi-square   the mean of r^2, against 1 + 6 standard deviations
//   structure    for each neighbour d of (0,1), (1,0), (1,1), (1,-1), (0,2), (2,0): z_d = sum of r(p) r(p + d) over all
//                pixels p of all frames, over the square root of the number of pairs. The sum of z_d^2 is chi-square
//                distributed with 6 degrees of freedom: 50 is exceeded once in 2e8 calibrations. Patterns of the
//                width of a fringe that are far below the noise of a pixel add up.
// A map also fits some of the noise: chi-square falls below 1, and the residuals are correlated. With the relative loss
// 1 - chi-square of the power, the sum of z_d^2 grows by 0.2 to 0.4 times pixels times its square (measured); a limit
// that is larger by once this product allows for it.
// Reference: Box and Pierce 1970, J. Am. Stat. Assoc. 65, 1509, here in two dimensions.
#include "calibrate/verdict.hpp"

#include <algorithm>
#include <cmath>

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

double median_of(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<long>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Results of the frames of a window, with both uncertainties of their separation.
void describe_frames(const Joint &joint, const Problem &problem, const Point &point, const Linearisation &normal,
                     size_t window, Calibration &out, std::vector<double> &alone, std::vector<double> &added) {
    for (const size_t frame : problem.windows[window].frames) {
        fit::Result &result = out.frames[frame], known;
        const Block &block = normal.blocks[frame];
        const fit::Fit::Start start = joint.fit().start_of(problem.frames.predictions[frame]);
        joint.fit().describe(point.own[frame].data(), out.uncertainty.alone[frame].data(), known);
        joint.fit().describe(point.own[frame].data(), out.uncertainty.whole[frame].data(), result);
        result.displacement_px = result.values[0] - start.separation_px;
        const auto pixels = static_cast<double>(block.used);
        result.chi_square = block.chi_square / (pixels - static_cast<double>(kOwn));
        result.excluded = block.saturated;
        if (block.saturated > 0)
            result.flags |= fit::saturated;
        if (result.chi_square > 1 + fit::kOutlierSigmas * std::sqrt(2 * pixels + block.inverse_counts) / pixels)
            result.flags |= fit::outlier;
        alone.push_back(std::sqrt(known.covariance[0]));
        added.push_back(std::sqrt(std::max(0.0, result.covariance[0] - known.covariance[0])));
    }
}

} // namespace

Buffer<double> whitened_frame(const Problem &problem, const Point &point, size_t frame) {
    Buffer<double> image;
    for (size_t window = 0; window < problem.windows.size(); window++) {
        const std::vector<size_t> &frames = problem.windows[window].frames;
        if (std::find(frames.begin(), frames.end(), frame) == frames.end())
            continue;
        const Joint joint(problem, point, window);
        const size_t pixels = joint.fit().rows() * joint.fit().cols();
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
    out.frames.assign(problem.frames.count, {});
    out.chi_map.resize(rows * cols);
    std::vector<double> alone, added;
    Correlation correlation;
    Buffer<double> counted(rows * cols);
    for (size_t window = 0; window < problem.windows.size(); window++) {
        const Joint joint(problem, point, window);
        describe_frames(joint, problem, point, normal, window, out, alone, added);
        double chi_square = 0, used = 0;
        joint.whiten(problem.windows[window].frames, [&](const Whitened &whitened) {
            correlation.add(whitened.residual, rows, cols);
            for (size_t i = 0; i < rows * cols; i++) {
                out.chi_map[i] += whitened.residual[i] * whitened.residual[i];
                counted[i] += whitened.residual[i] != 0 ? 1 : 0;
            }
            if (whitened.frame == 0) {
                out.after.resize(rows * cols);
                std::copy_n(whitened.residual, rows * cols, out.after.data());
            }
            const Block &block = normal.blocks[whitened.frame];
            chi_square += block.chi_square;
            used += static_cast<double>(block.used) - static_cast<double>(kOwn);
        });
        out.chi_square_of.push_back(chi_square / used);
    }
    for (size_t i = 0; i < rows * cols; i++)
        out.chi_map[i] /= std::max(1.0, counted[i]);
    out.separation_sigma_px = median_of(alone);
    out.calibration_sigma_px = median_of(added);
    out.structure = correlation.structure();
    const auto pixels = static_cast<double>(normal.used);
    const double fitted = static_cast<double>(problem.frames.count * kOwn + size);
    out.chi_square = normal.chi_square / (pixels - fitted);
    out.chi_square_sigma = std::sqrt(2 * pixels + normal.inverse_counts) / (pixels - fitted);
    const double loss = std::max(0.0, 1 - out.chi_square);
    out.structure_limit = kStructureLimit + (point.map_m.empty() ? 0 : pixels * loss * loss);
    if (out.chi_square > 1 + fit::kOutlierSigmas * out.chi_square_sigma || out.structure > out.structure_limit)
        out.flags |= incomplete;
    for (size_t i = 0; i < size; i++) {
        const double sigma = std::sqrt(out.uncertainty.instrument[i * size + i]);
        if (sigma > kHeld * problem.free[i % n].sigma)
            out.flags |= held;
    }
    if (std::find(out.even.begin(), out.even.end(), true) != out.even.end())
        out.flags |= no_sign;
}

} // namespace toliman::calibrate
