// Method: Gauss-Newton steps of all unknowns: the relative changes d of the pixels' response, the parameters t_k of
// each frame, those q of the instrument. They minimise
//     sum over frames and pixels of (y - dark - (1 + d) R m(t_k, q))^2/V + sum over pixels of (d/rms)^2
// and the priors of q. Stars move by pixels from frame to frame and the response does not, so that it differs from the
// optics, which move with the stars. In a frame, d has the matrix D, diagonal; t_k and q are few. With t_k and q
// eliminated exactly (response_frames.cpp), d solves
//     S d = (D - sum of A_k F_k^-1 A_k' - E Q^-1 E') d = b,
// E the coupling to q, Q the instrument's matrix with its priors, both after the elimination of t_k. With s = D^-1/2,
// s S s = 1 - M, and M is positive with the trace 7 + n: a few eigenvalues are near 1, of responses that imitate other
// parameters, and all others small. Conjugate gradients, in the form of Lanczos (1950) with complete orthogonalisation,
// need 2 to 10 products. Each reads all frames once.
// Errors: S^-1 = s (1 - M)^-1 s. The diagonals of 1 and M are known exactly. The rest, (1 - M)^-1 - 1 - M, comes from
// the few large eigenvalues, which the Lanczos vectors V of two random vectors find: V (T^-1 + T - 2) V', T = V'(1 - M)
// V. (Those of b do not: b lacks the responses that imitate other parameters.) What is missing is of the second order
// in eigenvalues that are small: 0.15 % of the error of 784 pixels in 60 frames, against the inverse of the whole
// matrix (tests/bind/test_response.py).
// The fluxes of all frames are free, so that a common factor is not determined: 1 + d is an eigenvector of S with the
// eigenvalue 1/rms^2. The prior makes the mean of d 0, to d^2, and the errors are those of the response over its mean:
// with a large weight of 1 + d in S. A linear change of the response is nearly one of the fluxes, too; it stays at the
// prior.
// Reference: Nocedal and Wright 2006, Numerical Optimization, chapters 5 and 10.
#include "calibrate/response.hpp"

#include <algorithm>
#include <cmath>

#include "base/hash.hpp"
#include "base/symmetric.hpp"
#include "calibrate/memo.hpp"
#include "calibrate/response_frames.hpp"
#include "calibrate/solve.hpp"
#include "calibrate/vectors.hpp"
#include "kernels/poisson.hpp"
#include "kernels/random.hpp"

namespace toliman::calibrate {

namespace {

constexpr size_t kStarts = 2; // random vectors of the errors
constexpr double kFixed = 3;  // weight of 1 + d: its error is then 1/kFixed^2 of that of the mean of known pixels

// Orthonormal vectors V, the matrix T = V'(1 - M) V and its inverse.
struct Krylov {
    std::vector<Buffer<double>> vectors;
    std::vector<std::vector<double>> rows; // of T, up to the diagonal
    Buffer<double> inverse;

    double at(size_t i, size_t j) const noexcept { return i > j ? rows[i][j] : rows[j][i]; }
    // False if T is singular.
    bool invert() {
        const size_t n = rows.size();
        inverse.assign(n * n, 0);
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++)
                inverse[i * n + j] = at(i, j);
        return invert_symmetric(inverse.data(), n);
    }
    // Makes a vector orthogonal to all; the products with them, of the first pass.
    std::vector<double> orthogonalise(Buffer<double> &vector) const {
        std::vector<double> products;
        for (int repeated = 0; repeated < 2; repeated++)
            for (const Buffer<double> &other : vectors) {
                const double product = dot(other, vector);
                if (repeated == 0)
                    products.push_back(product);
                add_scaled(-product, other, vector);
            }
        return products;
    }
};

optics::Outline outline_of(const Problem &problem, const Point &point) {
    optics::Outline outline = outline_at(problem, point.instrument[0], point.map_m);
    if (!point.response.empty())
        change_response(point.response, outline.scene.detector);
    return outline;
}

class ResponseFit {
  public:
    ResponseFit(const Problem &problem, const Point &point, const ResponseOptions &options)
        : problem_(problem), point_(point), options_(options), joint_(problem, point, 0),
          planes_(outline_of(problem, point), problem.parameters(), problem.capture_px, problem.frames.mean_spread()),
          frames_(problem, point, joint_) {}

    ResponseStep step();

  private:
    bool covers() const;
    bool prepare();
    Buffer<double> coupled(const Buffer<double> &v) const;
    Buffer<double> product(const Buffer<double> &vector, const Buffer<double> &fixed) const;
    Buffer<double> right() const;
    bool expand(Buffer<double> right, const Buffer<double> &fixed, Krylov &krylov) const;
    bool solve(ResponseStep &step) const;
    bool measure_errors(ResponseStep &step) const;
    Buffer<double> scaled(Buffer<double> vector, const std::vector<double> &weights) const;
    bool measure_separation(ResponseStep &step) const;
    void measure_covariance(const Krylov &krylov, ResponseStep &step) const;
    void finish(ResponseStep &step);

    const Problem &problem_;
    const Point &point_;
    const ResponseOptions &options_;
    const Joint joint_;
    const Planes planes_;
    ResponseFrames frames_;
    ResponseFrames::Equations equations_;
    Buffer<double> inverse_, scale_; // Q^-1 [n][n]; s
};

bool ResponseFit::covers() const {
    return std::all_of(point_.own.begin(), point_.own.end(), [this](const auto &own) {
        return planes_.covers(own.data()) && joint_.first().model().covers(own.data());
    });
}

bool ResponseFit::prepare() {
    equations_ = frames_.linearise(planes_);
    Uncertainty others = uncertainty_of(problem_, equations_.normal);
    inverse_ = std::move(others.instrument);
    scale_.resize(equations_.diagonal.size());
    for (size_t i = 0; i < scale_.size(); i++)
        scale_[i] = 1 / std::sqrt(equations_.diagonal[i] + 1 / (options_.rms * options_.rms));
    return equations_.solvable && others.solvable;
}

// Q^-1 E' v.
Buffer<double> ResponseFit::coupled(const Buffer<double> &v) const {
    const size_t n = equations_.instrument.size();
    Buffer<double> result(n);
    for (size_t j = 0; j < n; j++) {
        const double product = dot(equations_.instrument[j], v);
        for (size_t i = 0; i < n; i++)
            result[i] += inverse_[i * n + j] * product;
    }
    return result;
}

// 1 - M times a vector; plus f f' times it with the vector f = fixed, unless that is empty.
Buffer<double> ResponseFit::product(const Buffer<double> &vector, const Buffer<double> &fixed) const {
    Buffer<double> v = vector;
    for (size_t i = 0; i < v.size(); i++)
        v[i] *= scale_[i];
    ResponseFrames::Projections unused;
    Buffer<double> sum = frames_.product(v, unused);
    const Buffer<double> instrument = coupled(v);
    for (size_t j = 0; j < instrument.size(); j++)
        add_scaled(instrument[j], equations_.instrument[j], sum);
    Buffer<double> result = vector;
    for (size_t i = 0; i < result.size(); i++)
        result[i] -= scale_[i] * sum[i];
    if (!fixed.empty())
        add_scaled(dot(fixed, vector), fixed, result);
    return result;
}

// s b.
Buffer<double> ResponseFit::right() const {
    std::vector<Buffer<double>> gradients;
    for (const Block &block : equations_.normal.blocks)
        gradients.push_back(block.gradient);
    const Point alone = Solver(problem_, equations_.normal).solve(gradients, &point_); // without the response
    Buffer<double> right = equations_.gradient;
    for (size_t j = 0; j < equations_.instrument.size(); j++)
        add_scaled(-alone.instrument[0][j], equations_.instrument[j], right);
    if (!point_.response.empty())
        add_scaled(-1 / (options_.rms * options_.rms), point_.response, right);
    for (size_t i = 0; i < right.size(); i++)
        right[i] *= scale_[i];
    return right;
}

// Adds the Lanczos vectors from `next` on, until they contain the solution.
bool ResponseFit::expand(Buffer<double> next, const Buffer<double> &fixed, Krylov &krylov) const {
    const size_t first = krylov.vectors.size(), most = first + static_cast<size_t>(options_.most_iterations);
    krylov.orthogonalise(next);
    double length = std::sqrt(dot(next, next)), residual = 1; // relative
    while (length > 0 && residual > options_.tolerance && krylov.vectors.size() < most) {
        for (double &value : next)
            value /= length;
        krylov.vectors.push_back(std::move(next));
        const Buffer<double> &newest = krylov.vectors.back();
        next = recalled<Buffer<double>>(problem_.memo, {hash_of(point_), fnv1a(newest, kFnvOffset)},
                                        [&] { return product(newest, fixed); });
        krylov.rows.push_back(krylov.orthogonalise(next));
        length = std::sqrt(dot(next, next));
        if (!krylov.invert())
            return false;
        const size_t n = krylov.vectors.size();
        residual = length * std::fabs(krylov.inverse[first * n + n - 1]);
        problem_.settings.progress.report("response", std::min(1.0, std::log(residual) / std::log(options_.tolerance)));
    }
    return true;
}

// The change of the response.
bool ResponseFit::solve(ResponseStep &step) const {
    const Buffer<double> right = this->right();
    Krylov krylov;
    if (!expand(right, {}, krylov))
        return false;
    const size_t n = krylov.vectors.size();
    Buffer<double> &change = step.change.response;
    change.resize(right.size());
    for (size_t i = 0; i < n; i++)
        add_scaled(std::sqrt(dot(right, right)) * krylov.inverse[i * n], krylov.vectors[i], change);
    step.largest = std::sqrt(dot(change, change) / static_cast<double>(change.size()));
    for (size_t i = 0; i < change.size(); i++)
        change[i] *= scale_[i];
    return true;
}

bool ResponseFit::measure_errors(ResponseStep &step) const {
    const size_t m = equations_.instrument.size(), pixels = scale_.size();
    Buffer<double> fixed = scale_, variance(pixels, 1.0);
    for (size_t i = 0; i < point_.response.size(); i++)
        fixed[i] *= 1 + point_.response[i];
    const double size = std::sqrt(dot(fixed, fixed));
    for (double &value : fixed)
        value *= kFixed / size;
    Krylov krylov;
    kernels::Rng random(0, kernels::kStreamProbe);
    for (size_t start = 0; start < kStarts; start++) {
        Buffer<double> probe(pixels);
        for (double &sign : probe)
            sign = random.uniform() < 0.5 ? -1 : 1;
        if (!expand(std::move(probe), fixed, krylov))
            return false;
    }
    for (size_t i = 0; i < pixels; i++) {
        double eliminated = equations_.eliminated[i];
        for (size_t j = 0; j < m; j++)
            for (size_t k = 0; k < m; k++)
                eliminated += equations_.instrument[j][i] * inverse_[j * m + k] * equations_.instrument[k][i];
        variance[i] += scale_[i] * scale_[i] * eliminated - fixed[i] * fixed[i];
    }
    const size_t n = krylov.vectors.size();
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++) {
            const double factor = krylov.inverse[a * n + b] + krylov.at(a, b) - (a == b ? 2 : 0);
            for (size_t i = 0; i < pixels; i++)
                variance[i] += factor * krylov.vectors[a][i] * krylov.vectors[b][i];
        }
    step.sigma.resize(pixels);
    for (size_t i = 0; i < pixels; i++)
        step.sigma[i] = scale_[i] * std::sqrt(variance[i]);
    measure_covariance(krylov, step);
    return measure_separation(step);
}

// s (vector + E Q^-1 weights).
Buffer<double> ResponseFit::scaled(Buffer<double> vector, const std::vector<double> &weights) const {
    const size_t m = equations_.instrument.size();
    for (size_t k = 0; k < m; k++) {
        double factor = 0;
        for (size_t j = 0; j < m; j++)
            factor += inverse_[k * m + j] * weights[j];
        add_scaled(factor, equations_.instrument[k], vector);
    }
    for (size_t i = 0; i < vector.size(); i++)
        vector[i] *= scale_[i];
    return vector;
}

// Q^-1 E' S^-1 E Q^-1, with S^-1 = s (1 + V (T^-1 - 1) V') s.
void ResponseFit::measure_covariance(const Krylov &krylov, ResponseStep &step) const {
    const size_t m = equations_.instrument.size(), n = krylov.vectors.size();
    std::vector<Buffer<double>> columns; // s E Q^-1
    std::vector<std::vector<double>> along(n, std::vector<double>(m));
    for (size_t j = 0; j < m; j++) {
        std::vector<double> unit(m);
        unit[j] = 1;
        columns.push_back(scaled(Buffer<double>(scale_.size()), unit));
        for (size_t a = 0; a < n; a++)
            along[a][j] = dot(krylov.vectors[a], columns[j]);
    }
    step.covariance.resize(m * m);
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++) {
            double sum = dot(columns[i], columns[j]);
            for (size_t a = 0; a < n; a++)
                for (size_t b = 0; b < n; b++)
                    sum += (krylov.inverse[a * n + b] - (a == b ? 1 : 0)) * along[a][i] * along[b][j];
            step.covariance[i * m + j] = sum;
        }
}

// The mean separation changes by -u'd - g'q, u and g as in Equations, and q by -Q^-1 E'd with d, otherwise
// independently of it. The variance is g' Q^-1 g + c' S^-1 c with c = u - E Q^-1 g.
bool ResponseFit::measure_separation(ResponseStep &step) const {
    const size_t m = equations_.instrument.size();
    std::vector<double> minus = equations_.separation_gain;
    double variance = 0;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++)
            variance += minus[i] * inverse_[i * m + j] * minus[j];
    for (double &gain : minus)
        gain = -gain;
    const Buffer<double> right = scaled(equations_.separation, minus);
    Krylov krylov;
    if (!expand(right, {}, krylov))
        return false;
    if (!krylov.inverse.empty())
        variance += dot(right, right) * krylov.inverse[0];
    step.separation_sigma_px = std::sqrt(variance);
    return true;
}

// The other parameters for the change of the response.
void ResponseFit::finish(ResponseStep &step) {
    const size_t n = equations_.instrument.size();
    Linearisation &normal = equations_.normal;
    ResponseFrames::Projections projected;
    frames_.product(step.change.response, projected);
    const Uncertainty others = uncertainty_of(problem_, normal);
    for (size_t frame = 0; frame < projected.size(); frame++) {
        Block &block = normal.blocks[frame];
        for (size_t k = 0; k < kOwn; k++) {
            block.gradient[k] -= projected[frame][k];
            double step_of = 0; // F^-1 A' d
            for (size_t l = 0; l < kOwn; l++)
                step_of += others.alone[frame][k * kOwn + l] * projected[frame][l];
            for (size_t j = 0; j < n; j++)
                block.gradient[kOwn + j] -= block.matrix[k * (kOwn + n) + kOwn + j] * step_of;
        }
    }
    for (size_t j = 0; j < n; j++)
        normal.blocks[0].gradient[kOwn + j] -= dot(equations_.instrument[j], step.change.response);
    Step rest = step_from(problem_, point_, normal, 0); // jitter remains possible
    step.solvable = rest.solvable;
    step.change.instrument = std::move(rest.change.instrument);
    step.change.own = std::move(rest.change.own);
    step.largest = std::max(step.largest, rest.largest);
}

ResponseStep ResponseFit::step() {
    ResponseStep step;
    step.lost = !covers();
    if (step.lost || !prepare())
        return step;
    step.chi_square = equations_.normal.chi_square;
    step.used = equations_.normal.used;
    if (!solve(step))
        return step;
    finish(step);
    if (step.largest < options_.still && !measure_errors(step))
        step.solvable = false;
    return step;
}

} // namespace

ResponseStep response_step(const Problem &problem, const Point &point, const ResponseOptions &options) {
    return ResponseFit(problem, point, options).step();
}

double response_parameters(const Buffer<double> &sigma, double rms) noexcept {
    double sum = -1; // the mean
    for (const double one : sigma)
        sum += 1 - one * one / (rms * rms);
    return sum;
}

} // namespace toliman::calibrate
