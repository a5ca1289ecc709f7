// Method: with H = (A B; B' D) and gradient (a; d) the block of a frame, A that of its own parameters, the elimination
// of these leaves for the instrument
//     S = sum over frames of (D - B' A^-1 B) + P,   b = sum of (d - B' A^-1 a) - P q,
// with the priors' inverse covariance P at the changes q: Schur complement. The step of the instrument is S^-1 b, that
// of a frame's own parameters A^-1 (a - B step): exactly those of the whole system, whose size grows with the frames.
// Where the model does not fit yet, its error acts as noise: all variances are multiplied by chi-square per pixel, so
// that the priors count. Otherwise the first steps from 100 nm of aberrations lead to impossible spectra and jitter.
// Damping l multiplies the diagonals of A and of sum D + P by 1 + l (Marquardt 1963).
// With windows, the instrument's values q of a frame are interpolated between those at two starts, q = T (q_1 q_2): D,
// B and d of these are T'DT, BT and T'd.
// Prior: each parameter is normal around 0 at the first start, and its change from one start to the next is normal
// around 0 with `smoothness` times the standard deviation (random walk).
// Covariance: S^-1 of the instrument, and A^-1 + T S^-1 T' with T = A^-1 B of a frame.
// Reference: Triggs et al. 2000, Bundle Adjustment - A Modern Synthesis, LNCS 1883, 298.
#include "calibrate/solve.hpp"

#include <algorithm>
#include <cmath>

#include "base/symmetric.hpp"
#include "scene/instrument.hpp"

namespace toliman::calibrate {

// A frame's own parameters eliminated: A^-1, T = A^-1 B [own][n], A^-1 a.
struct Eliminated {
    std::array<double, kOwn * kOwn> inverse;
    Buffer<double> gain;
    std::array<double, kOwn> step;
};

// The instrument's normal equations in all windows.
struct Reduced {
    size_t n = 0, size = 0;        // parameters; times starts of windows
    Buffer<double> matrix, vector; // [size][size], [size]
    Buffer<double> diagonal;       // of the equations before elimination, [size]
    std::vector<Eliminated> frames;
    bool solvable = false;
};

namespace {

using Kind = Parameter::Kind;

// inverse = A^-1, gain = A^-1 B, step = A^-1 a, with the damping in A. False if A is singular.
bool eliminate(const Block &block, size_t n, double damping, Eliminated &out) {
    const size_t size = kOwn + n;
    for (size_t i = 0; i < kOwn; i++)
        for (size_t j = 0; j < kOwn; j++)
            out.inverse[i * kOwn + j] = block.matrix[i * size + j] * (i == j ? 1 + damping : 1);
    if (!invert_symmetric(out.inverse.data(), kOwn))
        return false;
    out.gain.resize(kOwn * n);
    for (size_t i = 0; i < kOwn; i++) {
        double step = 0;
        for (size_t k = 0; k < kOwn; k++) {
            const double factor = out.inverse[i * kOwn + k];
            step += factor * block.gradient[k];
            for (size_t j = 0; j < n; j++)
                out.gain[i * n + j] += factor * block.matrix[k * size + kOwn + j];
        }
        out.step[i] = step;
    }
    return true;
}

void add_frame(const Block &block, const Eliminated &frame, const std::vector<Part> &parts, double weight,
               Reduced &sum) {
    const size_t n = sum.n, size = kOwn + n;
    for (size_t i = 0; i < n; i++) {
        const double *const own = &block.matrix[(kOwn + i) * size]; // B'
        double gradient = block.gradient[kOwn + i];
        for (size_t k = 0; k < kOwn; k++)
            gradient -= own[k] * frame.step[k];
        for (const Part &a : parts) {
            sum.vector[a.window * n + i] += weight * a.share * gradient;
            sum.diagonal[a.window * n + i] += weight * a.share * a.share * own[kOwn + i];
        }
        for (size_t j = 0; j < n; j++) {
            double value = own[kOwn + j];
            for (size_t k = 0; k < kOwn; k++)
                value -= own[k] * frame.gain[k * n + j];
            for (const Part &a : parts)
                for (const Part &b : parts)
                    sum.matrix[(a.window * n + i) * sum.size + b.window * n + j] += weight * a.share * b.share * value;
        }
    }
}

// Calls add(first, second, weight) for each term of the prior, weight (q[first] - q[second])^2; second may be none.
constexpr size_t kNone = static_cast<size_t>(-1);
template <class Add> void for_prior(const Problem &problem, const Add &add) {
    const size_t n = problem.free.size();
    for (size_t window = 0; window < problem.windows.size(); window++)
        for (size_t i = 0; i < n; i++) {
            const double steps = problem.smoothness * std::sqrt(problem.windows[window].elapsed),
                         sigma = problem.free[i].sigma * (window == 0 ? 1 : steps);
            add(window * n + i, window == 0 ? kNone : (window - 1) * n + i, 1 / (sigma * sigma));
        }
}

double value_at(const Point &point, size_t n, size_t i) {
    return point.instrument[i / n][i % n];
}

// point: NULL adds the matrix of the prior only.
void add_prior(const Problem &problem, const Point *point, Reduced &sum) {
    for_prior(problem, [&](size_t i, size_t j, double weight) {
        const auto at = [&](size_t a, size_t b) -> double & { return sum.matrix[a * sum.size + b]; };
        const double pull = point == nullptr
                                ? 0
                                : weight * (value_at(*point, sum.n, i) - (j == kNone ? 0 : value_at(*point, sum.n, j)));
        at(i, i) += weight;
        sum.diagonal[i] += weight;
        sum.vector[i] -= pull;
        if (j == kNone)
            return;
        at(j, j) += weight;
        sum.diagonal[j] += weight;
        sum.vector[j] += pull;
        at(i, j) -= weight;
        at(j, i) -= weight;
    });
}

// excess: factor of all variances.
Reduced reduced(const Problem &problem, const Point *point, const Linearisation &normal, double excess,
                double damping) {
    Reduced sum;
    sum.n = problem.free.size();
    sum.size = sum.n * problem.windows.size();
    sum.matrix.resize(sum.size * sum.size);
    sum.vector.resize(sum.size);
    sum.diagonal.resize(sum.size);
    sum.frames.resize(normal.blocks.size());
    sum.solvable = true;
    problem.for_frames([&](size_t frame, const std::vector<Part> &parts) {
        sum.solvable = sum.solvable && eliminate(normal.blocks[frame], sum.n, damping, sum.frames[frame]);
        if (sum.solvable)
            add_frame(normal.blocks[frame], sum.frames[frame], parts, 1 / excess, sum);
    });
    add_prior(problem, point, sum);
    return sum;
}

// Solves for the unknowns that are not fixed, with the change of the fixed ones in `change`.
bool solve(const Reduced &sum, const Buffer<double> &matrix, const std::vector<bool> &fixed,
           std::vector<double> &change) {
    std::vector<size_t> open;
    for (size_t i = 0; i < sum.size; i++)
        if (!fixed[i])
            open.push_back(i);
    const size_t count = open.size();
    Buffer<double> inverse(count * count), right(count);
    for (size_t i = 0; i < count; i++) {
        right[i] = sum.vector[open[i]];
        for (size_t j = 0; j < sum.size; j++)
            right[i] -= fixed[j] ? matrix[open[i] * sum.size + j] * change[j] : 0;
        for (size_t j = 0; j < count; j++)
            inverse[i * count + j] = matrix[open[i] * sum.size + open[j]];
    }
    if (!invert_symmetric(inverse.data(), count))
        return false;
    for (size_t i = 0; i < count; i++) {
        double value = 0;
        for (size_t j = 0; j < count; j++)
            value += inverse[i * count + j] * right[j];
        change[open[i]] = value;
    }
    return true;
}

// Fixes jitter and diffusion of each window where the step would make their sum impossible: its change becomes that to
// the nearest possible covariance. Whether any was fixed: the step of the others must then be solved, and held, again.
bool hold_jitter(const Problem &problem, const Point &point, std::vector<double> &change, std::vector<bool> &fixed) {
    const size_t n = problem.free.size();
    bool any = false;
    for (size_t window = 0; window < problem.windows.size(); window++) {
        std::vector<double> values = point.instrument[window];
        for (size_t i = 0; i < n; i++)
            values[i] += change[window * n + i];
        const Scene scene = scene_at(problem, values);
        Jitter wanted = scene.systematics.jitter;
        wanted.xx += scene.detector.diffusion_px2;
        wanted.yy += scene.detector.diffusion_px2;
        Jitter possible = wanted;
        const auto first = fixed.begin() + static_cast<std::ptrdiff_t>(window * n);
        const bool is_held =
            std::find(first, first + static_cast<std::ptrdiff_t>(n), true) != first + static_cast<std::ptrdiff_t>(n);
        if (is_held || !make_possible(possible))
            continue;
        for (size_t i = 0; i < n; i++) {
            const Kind kind = problem.free[i].parameter.kind;
            const double by = kind == Kind::jitter_xx   ? possible.xx - wanted.xx
                              : kind == Kind::jitter_yy ? possible.yy - wanted.yy
                              : kind == Kind::jitter_xy ? possible.xy - wanted.xy
                                                        : 0.5 * (possible.xx - wanted.xx + possible.yy - wanted.yy);
            if (kind != Kind::jitter_xx && kind != Kind::jitter_yy && kind != Kind::jitter_xy &&
                kind != Kind::diffusion)
                continue;
            change[window * n + i] += by;
            fixed[window * n + i] = any = true;
        }
    }
    return any;
}

// Of the parameters j and i of a frame with these parts, from the inverse in place of the matrix.
double covariance_of(const Reduced &sum, const std::vector<Part> &parts, size_t j, size_t i) noexcept {
    double covariance = 0;
    for (const Part &a : parts)
        for (const Part &b : parts)
            covariance += a.share * b.share * sum.matrix[(a.window * sum.n + j) * sum.size + b.window * sum.n + i];
    return covariance;
}

} // namespace

double prior_cost(const Problem &problem, const Point &point) {
    const size_t n = problem.free.size();
    double sum = 0;
    for_prior(problem, [&](size_t i, size_t j, double weight) {
        const double distance = value_at(point, n, i) - (j == kNone ? 0 : value_at(point, n, j));
        sum += weight * distance * distance;
    });
    return sum;
}

Step step_from(const Problem &problem, const Point &point, const Linearisation &normal, double damping) {
    Step step;
    const Reduced sum = reduced(problem, &point, normal, normal.excess, damping);
    if (!sum.solvable)
        return step;
    Buffer<double> damped = sum.matrix, covariance = sum.matrix;
    for (size_t i = 0; i < sum.size; i++)
        damped[i * sum.size + i] += damping * sum.diagonal[i];
    std::vector<double> change(sum.size);
    std::vector<bool> fixed(sum.size);
    if (!solve(sum, damped, fixed, change) || !invert_symmetric(covariance.data(), sum.size))
        return step;
    while (hold_jitter(problem, point, change, fixed)) // one window more each time
        if (!solve(sum, damped, fixed, change))
            return step;
    step.change.instrument.resize(problem.windows.size());
    step.change.own.resize(problem.frames.count);
    for (size_t window = 0; window < problem.windows.size(); window++)
        step.change.instrument[window].assign(&change[window * sum.n], &change[window * sum.n] + sum.n);
    problem.for_frames([&](size_t frame, const std::vector<Part> &parts) {
        const std::vector<double> of_frame = sum_of(step.change.instrument, parts);
        for (size_t k = 0; k < kOwn; k++) {
            double value = sum.frames[frame].step[k];
            for (size_t i = 0; i < sum.n; i++)
                value -= sum.frames[frame].gain[k * sum.n + i] * of_frame[i];
            step.change.own[frame][k] = value;
        }
    });
    for (size_t i = 0; i < sum.size; i++)
        step.largest = std::max(step.largest, std::fabs(change[i]) / std::sqrt(covariance[i * sum.size + i]));
    for (size_t frame = 0; frame < sum.frames.size(); frame++)
        for (size_t k = 0; k < kOwn; k++)
            step.largest =
                std::max(step.largest, std::fabs(step.change.own[frame][k]) /
                                           std::sqrt(normal.excess * sum.frames[frame].inverse[k * kOwn + k]));
    step.solvable = true;
    return step;
}

double gain_of_step(const Problem &problem, const Point &point, const Linearisation &normal) {
    const size_t n = problem.free.size(), size = kOwn + n;
    const Step step = step_from(problem, point, normal, 0);
    if (!step.solvable)
        return 0;
    double gain = 0;
    problem.for_frames([&](size_t frame, const std::vector<Part> &parts) {
        const std::vector<double> of_frame = sum_of(step.change.instrument, parts);
        const Block &block = normal.blocks[frame];
        for (size_t i = 0; i < size; i++)
            gain += block.gradient[i] * (i < kOwn ? step.change.own[frame][i] : of_frame[i - kOwn]) / normal.excess;
    });
    // The prior's: half its derivative along the step, as its cost is quadratic.
    Point moved = point;
    for (size_t window = 0; window < moved.instrument.size(); window++)
        for (size_t i = 0; i < n; i++)
            moved.instrument[window][i] += step.change.instrument[window][i];
    return gain - (prior_cost(problem, moved) - prior_cost(problem, point) - prior_cost(problem, step.change)) / 2;
}

struct Solver::Equations {
    Reduced sum; // with the inverse in place of the matrix
    double excess;
};

Solver::Solver(const Problem &problem, const Linearisation &normal)
    : problem_(problem), equations_(std::make_unique<Equations>(
                             Equations{reduced(problem, nullptr, normal, normal.excess, 0), normal.excess})) {
    Reduced &sum = equations_->sum;
    sum.solvable = sum.solvable && invert_symmetric(sum.matrix.data(), sum.size);
}

Solver::~Solver() = default;

bool Solver::solvable() const noexcept {
    return equations_->sum.solvable;
}

// In the symbols above: b, then S^-1 b, then A^-1 (a - B step) of each frame. gain is A^-1 B and inverse A^-1, both of
// the blocks without `excess`, the factor of all variances: it divides the gradients in b, and cancels in a frame's
// own.
Point Solver::solve(const std::vector<Buffer<double>> &gradients, const Point *point) const {
    const Reduced &sum = equations_->sum;
    const size_t n = sum.n;
    Buffer<double> vector(sum.size);
    if (point != nullptr)
        for_prior(problem_, [&](size_t i, size_t j, double weight) {
            const double pull = weight * (value_at(*point, n, i) - (j == kNone ? 0 : value_at(*point, n, j)));
            vector[i] -= pull;
            if (j != kNone)
                vector[j] += pull;
        });
    Point change;
    change.own.resize(gradients.size());
    change.instrument.assign(problem_.windows.size(), std::vector<double>(n));
    problem_.for_frames([&](size_t frame, const std::vector<Part> &parts) {
        for (size_t i = 0; i < n; i++) { // B' A^-1 is the transpose of the gain
            double gradient = gradients[frame][kOwn + i];
            for (size_t k = 0; k < kOwn; k++)
                gradient -= sum.frames[frame].gain[k * n + i] * gradients[frame][k];
            for (const Part &part : parts)
                vector[part.window * n + i] += part.share * gradient / equations_->excess;
        }
    });
    for (size_t i = 0; i < sum.size; i++)
        for (size_t j = 0; j < sum.size; j++)
            change.instrument[i / n][i % n] += sum.matrix[i * sum.size + j] * vector[j];
    problem_.for_frames([&](size_t frame, const std::vector<Part> &parts) {
        const std::vector<double> of_frame = sum_of(change.instrument, parts);
        for (size_t k = 0; k < kOwn; k++) {
            double value = 0;
            for (size_t l = 0; l < kOwn; l++)
                value += sum.frames[frame].inverse[k * kOwn + l] * gradients[frame][l];
            for (size_t i = 0; i < n; i++)
                value -= sum.frames[frame].gain[k * n + i] * of_frame[i];
            change.own[frame][k] = value;
        }
    });
    return change;
}

Uncertainty uncertainty_of(const Problem &problem, const Linearisation &normal) {
    Uncertainty result;
    Reduced sum = reduced(problem, nullptr, normal, 1, 0);
    if (!sum.solvable || !invert_symmetric(sum.matrix.data(), sum.size))
        return result;
    for (size_t i = 0; i < normal.of_response.size(); i++)
        sum.matrix[i] += normal.of_response[i];
    result.alone.resize(problem.frames.count);
    result.whole.resize(problem.frames.count);
    problem.for_frames([&](size_t frame, const std::vector<Part> &parts) {
        const Eliminated &of = sum.frames[frame];
        result.alone[frame] = result.whole[frame] = of.inverse;
        for (size_t k = 0; k < kOwn; k++)
            for (size_t i = 0; i < sum.n; i++) {
                double row = 0; // T S^-1
                for (size_t j = 0; j < sum.n; j++)
                    row += of.gain[k * sum.n + j] * covariance_of(sum, parts, j, i);
                for (size_t l = 0; l < kOwn; l++)
                    result.whole[frame][k * kOwn + l] += row * of.gain[l * sum.n + i];
            }
    });
    result.instrument = std::move(sum.matrix);
    result.solvable = true;
    return result;
}

} // namespace toliman::calibrate
