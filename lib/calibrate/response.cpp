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
// need a few tens of products. Each reads all frames once.
// Errors: S^-1 = s (1 - M)^-1 s. The diagonals of 1 and M are known exactly. The rest, (1 - M)^-1 - 1 - M, comes from
// the few large eigenvalues, which the Lanczos vectors V find with their matrix T: V (T^-1 + T - 2) V'. What is missing
// is of the second order in eigenvalues that are small, and reduces the error: by at most 0.2 % of 784 pixels in 60
// frames, against the inverse of the whole matrix (tests/bind/test_response.py).
// The fluxes of all frames are free, so that a common factor is not determined: 1 + d is an eigenvector of S with the
// eigenvalue 1/rms^2. The prior makes the mean of d 0, to d^2, and the errors are those of the response over its mean:
// without that eigenvector. A linear change of the response is nearly one of the fluxes, too; it stays at the prior.
// Reference: Nocedal and Wright 2006, Numerical Optimization, chapters 5 and 10.
#include "calibrate/response.hpp"

#include <algorithm>
#include <cmath>

#include "base/hash.hpp"
#include "base/symmetric.hpp"
#include "calibrate/memo.hpp"
#include "calibrate/response_frames.hpp"
#include "calibrate/solve.hpp"

namespace toliman::calibrate {

namespace {

constexpr double kLeastVariance = 0.01; // keeps rounding from a negative variance

double dot(const Buffer<double> &a, const Buffer<double> &b) noexcept {
    double sum = 0;
    for (size_t i = 0; i < a.size(); i++)
        sum += a[i] * b[i];
    return sum;
}

// a += factor b
void add_scaled(double factor, const Buffer<double> &b, Buffer<double> &a) noexcept {
    for (size_t i = 0; i < a.size(); i++)
        a[i] += factor * b[i];
}

// The matrix T of the Lanczos vectors.
struct Tridiagonal {
    std::vector<double> diagonal, off_diagonal;

    // T^-1 [size][size]; empty if T is singular.
    Buffer<double> inverse() const {
        const size_t n = diagonal.size();
        Buffer<double> matrix(n * n);
        for (size_t i = 0; i < n; i++) {
            matrix[i * n + i] = diagonal[i];
            if (i + 1 < n)
                matrix[i * n + i + 1] = matrix[(i + 1) * n + i] = off_diagonal[i];
        }
        return invert_symmetric(matrix.data(), n) ? matrix : Buffer<double>();
    }
    double at(size_t i, size_t j) const noexcept {
        return i == j ? diagonal[i] : j == i + 1 ? off_diagonal[i] : i == j + 1 ? off_diagonal[j] : 0;
    }
};

class ResponseFit {
  public:
    ResponseFit(const Problem &problem, const Point &point, const ResponseOptions &options)
        : problem_(problem), point_(point), options_(options), joint_(problem, point, 0),
          planes_(outline_at(problem, point.instrument[0], point.map_m), problem.parameters(), problem.capture_px,
                  problem.frames.mean_spread()),
          frames_(problem, point, joint_) {}

    ResponseStep step();

  private:
    bool covers() const;
    bool prepare();
    Buffer<double> coupled(const Buffer<double> &v) const;
    Buffer<double> product(const Buffer<double> &vector);
    Buffer<double> right() const;
    bool solve(const Buffer<double> &right, ResponseStep &step);
    void measure_errors(const Buffer<double> &inverse, ResponseStep &step) const;
    void finish(ResponseStep &step);

    const Problem &problem_;
    const Point &point_;
    const ResponseOptions &options_;
    const Joint joint_;
    const Planes planes_;
    ResponseFrames frames_;
    ResponseFrames::Equations equations_;
    Buffer<double> inverse_, scale_;      // Q^-1 [n][n]; s
    std::vector<Buffer<double>> vectors_; // of Lanczos
    Tridiagonal matrix_;
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

// 1 - M times a vector.
Buffer<double> ResponseFit::product(const Buffer<double> &vector) {
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

bool ResponseFit::solve(const Buffer<double> &right, ResponseStep &step) {
    const double size = std::sqrt(dot(right, right));
    step.change.response.resize(right.size());
    Buffer<double> inverse, next = right;
    double length = size;
    while (length > 0 && step.iterations < options_.most_iterations) {
        step.iterations++;
        for (double &value : next)
            value /= length;
        vectors_.push_back(std::move(next));
        const Buffer<double> &newest = vectors_.back();
        next = recalled<Buffer<double>>(problem_.memo, {hash_of(point_), fnv1a(newest, kFnvOffset)},
                                        [&] { return product(newest); });
        matrix_.diagonal.push_back(dot(newest, next));
        for (int repeated = 0; repeated < 2; repeated++)
            for (const Buffer<double> &vector : vectors_)
                add_scaled(-dot(vector, next), vector, next);
        length = std::sqrt(dot(next, next));
        matrix_.off_diagonal.push_back(length);
        inverse = matrix_.inverse();
        if (inverse.empty())
            return false;
        const size_t n = vectors_.size();
        const double residual = length * std::fabs(inverse[n - 1]); // relative to that of 0
        problem_.settings.progress.report("response", std::min(1.0, std::log(residual) / std::log(options_.tolerance)));
        if (residual < options_.tolerance)
            break;
    }
    const size_t n = vectors_.size();
    for (size_t i = 0; i < n; i++)
        add_scaled(size * inverse[i * n], vectors_[i], step.change.response);
    for (size_t i = 0; i < right.size(); i++)
        step.change.response[i] *= scale_[i];
    measure_errors(inverse, step);
    return true;
}

// inverse: T^-1.
void ResponseFit::measure_errors(const Buffer<double> &inverse, ResponseStep &step) const {
    const size_t n = vectors_.size(), m = equations_.instrument.size(), pixels = scale_.size();
    Buffer<double> variance(pixels, 1.0);
    for (size_t i = 0; i < pixels; i++) {
        double eliminated = equations_.eliminated[i];
        for (size_t j = 0; j < m; j++)
            for (size_t k = 0; k < m; k++)
                eliminated += equations_.instrument[j][i] * inverse_[j * m + k] * equations_.instrument[k][i];
        variance[i] += scale_[i] * scale_[i] * eliminated;
    }
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++) {
            const double factor = inverse[a * n + b] + matrix_.at(a, b) - (a == b ? 2 : 0);
            for (size_t i = 0; i < pixels; i++)
                variance[i] += factor * vectors_[a][i] * vectors_[b][i];
        }
    step.sigma.resize(pixels);
    const double of_mean = options_.rms * options_.rms / static_cast<double>(pixels);
    double square = 0;
    for (size_t i = 0; i < pixels; i++) {
        const double alone = scale_[i] * scale_[i]; // the variance, if all others were known
        step.sigma[i] = std::sqrt(std::max(kLeastVariance * alone, alone * variance[i] - of_mean));
        square += step.change.response[i] * step.change.response[i] / (step.sigma[i] * step.sigma[i]);
    }
    step.largest = std::sqrt(square / static_cast<double>(pixels));
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
}

ResponseStep ResponseFit::step() {
    ResponseStep step;
    step.lost = !covers();
    if (step.lost || !prepare())
        return step;
    step.chi_square = equations_.normal.chi_square;
    step.used = equations_.normal.used;
    if (solve(right(), step))
        finish(step);
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
