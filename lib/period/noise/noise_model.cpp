// Method: noise of covariance s_i s_j exp(-|t_i - t_j|/tau) is a first-order autoregression between irregular times.
// With phi_i = exp(-(t_i - t_(i-1))/tau) = rho^gap, for the gap in median steps,
//   e_i = (y_i/s_i - phi_i y_(i-1)/s_(i-1))/sqrt(1 - phi_i^2)
// has unit variance and no correlation, and log det C = sum log(1 - phi_i^2) + const. The recursion is applied to the
// values and to every column of the design, which takes O(N) per column instead of O(N^3) (Rybicki and Press 1995,
// Phys. Rev. Lett. 74, 1060). A prior is one further row of the whitened design, with value 0.
// The functions are orthogonalised once per rho by modified Gram-Schmidt, twice (Giraud et al. 2005, Numer. Math. 101,
// 87), and each frequency leaves 2 x 2 equations. Eight frequencies at a time are the lanes of a vector; cosines and
// sines advance by a rotation, and are computed again every kBlocks blocks. Where the functions take most of cosine or
// sine, or these nearly coincide, the sums cancel: vectors are then orthogonalised explicitly.
// The likelihood of rho is the restricted one (Patterson and Thompson 1971, Biometrika 58, 545): maximum likelihood
// underestimates the correlation, with the mean alone by (1 + 3 rho)/N (Marriott and Pope 1954, Biometrika 41, 390).
// Not modelled: a white component in addition to the exponential one, which needs a state-space recursion per
// frequency.
#include "period/noise/noise_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "kernels/cis.hpp"
#include "period/sampling.hpp"

namespace toliman::period {

namespace {

constexpr size_t kLanes = 8, kBlocks = 32;
// Squared length, relative to that before projection, below which a vector counts as a combination of others; and below
// which sums of the scan cancel.
constexpr double kDependent = 1e-20, kCancelled = 1e-4;
constexpr double kLeastSquare = 1e-300; // so that a perfect fit has a logarithm
constexpr double kUndetermined = std::numeric_limits<double>::infinity();
constexpr double kTwoPi = 2 * kPi;
constexpr double kReplaced = -1; // rho after the values were replaced

double unit_of(const double *values, size_t n, size_t stride) noexcept {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = std::max(most, std::fabs(values[i * stride]));
    int exponent = 0;
    std::frexp(most, &exponent);
    return std::ldexp(1.0, std::clamp(exponent, -1000, 1000));
}

} // namespace

NoiseModel::NoiseModel(const NoiseSamples &given, double last)
    : archive_(given.samples, last), n_(given.samples.n), m_(given.k + 1), rows_(n_ + given.k) {
    if (n_ < m_ + 5)
        fail(Status::state, "{n} = %zu: must be at least %zu, the number of functions and 6", n_, m_ + 5);
    if (archive_.constant())
        fail(Status::state, "{y}: all values are equal");
    order();
    scale_columns(given);
}

void NoiseModel::order() {
    const double *t = archive_.samples.t;
    order_.resize(n_);
    std::iota(order_.begin(), order_.end(), size_t{0});
    std::sort(order_.begin(), order_.end(), [&](size_t a, size_t b) { return t[a] < t[b] || (t[a] == t[b] && a < b); });
    step_ = cadence_of({t, t + n_}).step;
    for (Column *column : {&t_high_, &t_low_, &gap_, &weight_, &own_, &previous_})
        column->resize(n_);
    for (size_t i = 0; i < n_; i++) {
        const size_t at = order_[i];
        t_high_[i] = archive_.t_high[at];
        t_low_[i] = archive_.t_low[at];
        weight_[i] = archive_.samples.sigma != nullptr ? archive_.least_sigma / archive_.samples.sigma[at] : 1;
        if (i == 0)
            continue;
        const size_t before = order_[i - 1];
        if (t[at] == t[before])
            fail(Status::argument, "sample %zu: {t} = %g: must differ from that of sample %zu", at, t[at], before);
        gap_[i] = (t[at] - t[before]) / step_;
    }
}

void NoiseModel::scale_columns(const NoiseSamples &given) {
    columns_.resize(checked_product(m_ + 1, n_, "functions"));
    whitened_.resize(checked_product(m_ + 1, rows_, "functions"));
    triangle_.resize(m_ * m_);
    for (Column *column : {&unit_, &prior_, &along_})
        column->assign(m_, 0.0);
    unit_[0] = 1;
    value_unit_ = 1 / archive_.value_scale;
    for (size_t i = 0; i < n_; i++) {
        columns_[i] = 1;
        columns_[m_ * n_ + i] = (archive_.samples.y[order_[i]] - archive_.first_value) * archive_.value_scale;
    }
    for (size_t j = 1; j < m_; j++) {
        const double *values = given.functions + (j - 1), precision = given.precision ? given.precision[j - 1] : 0;
        for (size_t i = 0; i < n_; i++)
            if (!std::isfinite(values[i * given.k]))
                fail(Status::argument, "sample %zu: {functions}[%zu] = %g: must be finite", i, j - 1,
                     values[i * given.k]);
        if (!(std::isfinite(precision) && precision >= 0))
            fail(Status::argument, "{precision[%zu]} = %g: must be finite and at least 0", j - 1, precision);
        unit_[j] = unit_of(values, n_, given.k);
        for (size_t i = 0; i < n_; i++)
            columns_[j * n_ + i] = values[order_[i] * given.k] / unit_[j];
        prior_[j] = std::sqrt(precision) * archive_.least_sigma / unit_[j];
        free_ += precision == 0 ? 1 : 0;
    }
}

// e_i = own_i y_i - previous_i y_(i-1), with own_i = w_i/r_i, previous_i = phi_i w_(i-1)/r_i, r_i = sqrt(1 - phi_i^2)
// and the weights w = 1/s.
void NoiseModel::set_rho(double rho) {
    if (rho == rho_)
        return;
    rho_ = rho;
    log_determinant_ = 0;
    const double log_rho = rho > 0 ? std::log(rho) : -kUndetermined;
    own_[0] = weight_[0];
    previous_[0] = 0;
    for (size_t i = 1; i < n_; i++) {
        const double phi = std::exp(gap_[i] * log_rho), rest = -std::expm1(2 * gap_[i] * log_rho);
        const double factor = 1 / std::sqrt(rest);
        own_[i] = weight_[i] * factor;
        previous_[i] = phi * weight_[i - 1] * factor;
        log_determinant_ += std::log(rest);
    }
    for (size_t j = 0; j <= m_; j++) {
        whiten(&columns_[j * n_], column(j));
        std::fill(column(j) + n_, column(j) + rows_, 0.0);
        if (j > 0 && j < m_)
            column(j)[n_ + j - 1] = prior_[j];
    }
    orthogonalise();
}

void NoiseModel::whiten(const double *in, double *out) const noexcept {
    out[0] = own_[0] * in[0];
    for (size_t i = 1; i < n_; i++)
        out[i] = own_[i] * in[i] - previous_[i] * in[i - 1];
}

double NoiseModel::dot(const double *a, const double *b) const noexcept {
    double part[4] = {};
    size_t i = 0;
    for (; i + 4 <= rows_; i += 4)
        for (size_t j = 0; j < 4; j++)
            part[j] += a[i + j] * b[i + j];
    for (; i < rows_; i++)
        part[0] += a[i] * b[i];
    return (part[0] + part[1]) + (part[2] + part[3]);
}

// Removes the functions from a column; along [m] receives its components.
void NoiseModel::project(double *column, double *along, size_t functions) const noexcept {
    std::fill(along, along + functions, 0.0);
    for (int pass = 0; pass < 2; pass++)
        for (size_t j = 0; j < functions; j++) {
            const double *q = this->column(j), part = dot(q, column);
            along[j] += part;
            for (size_t i = 0; i < rows_; i++)
                column[i] -= part * q[i];
        }
}

// A function that depends on those before it becomes 0.
void NoiseModel::orthogonalise() noexcept {
    dependent_ = 0;
    for (size_t j = 0; j < m_; j++) {
        const double whole = dot(column(j), column(j));
        project(column(j), &triangle_[j * m_], j);
        const double square = dot(column(j), column(j)), length = std::sqrt(square);
        const bool depends = !(square > kDependent * whole);
        if (depends && dependent_ == 0)
            dependent_ = j;
        triangle_[j * m_ + j] = depends ? 0 : length;
        const double factor = depends ? 0 : 1 / length;
        for (size_t i = 0; i < rows_; i++)
            column(j)[i] *= factor;
    }
    const double whole = dot(column(m_), column(m_));
    project(column(m_), along_.data(), m_);
    null_residual_ = dot(column(m_), column(m_));
    described_ = !(null_residual_ > kDependent * whole);
}

void NoiseModel::check() const {
    if (described_)
        fail(Status::state, "{y}: mean and functions describe all values");
    if (dependent_ != 0)
        fail(Status::argument, "{functions}[%zu]: is a combination of the mean and the functions before it",
             dependent_ - 1);
}

double NoiseModel::time_variance() const noexcept {
    long double mean = 0, square = 0, sum = 0;
    for (size_t i = 0; i < n_; i++) {
        const long double w = static_cast<long double>(weight_[i]) * weight_[i];
        sum += w;
        mean += w * t_high_[i];
        square += w * t_high_[i] * t_high_[i];
    }
    mean /= sum;
    return static_cast<double>(square / sum - mean * mean);
}

NoiseWave NoiseModel::wave(double frequency) const {
    NoiseWave wave = {frequency, Column(n_), Column(n_)};
    for (size_t i = 0; i < n_; i++)
        kernels::cis_product(frequency, 0, t_high_[i], t_low_[i], wave.cosine[i], wave.sine[i]);
    return wave;
}

// First the larger one of cosine and sine, then the other one without the first.
struct NoiseModel::Directions {
    bool sine_first = false;
    int rank = 0;
    Column vector[2];           // of unit length
    Column along[2];            // components of cosine or sine along the functions
    double length[2] = {};      // before normalisation
    double second_on_first = 0; // component of the second before the first is removed
};

// Removes a unit vector from a column; returns its component.
double NoiseModel::remove(const double *direction, double *column) const noexcept {
    const double part = dot(direction, column);
    for (size_t i = 0; i < rows_; i++)
        column[i] -= part * direction[i];
    return part;
}

NoiseModel::Directions NoiseModel::directions(const NoiseWave &wave) const {
    Directions d;
    double whole = 0;
    for (int i = 0; i < 2; i++) {
        d.vector[i].resize(rows_);
        d.along[i].resize(m_);
        whiten((i == 0 ? wave.cosine : wave.sine).data(), d.vector[i].data());
        whole += dot(d.vector[i].data(), d.vector[i].data());
        project(d.vector[i].data(), d.along[i].data(), m_);
    }
    const auto normalise = [&](int i) {
        const double square = dot(d.vector[i].data(), d.vector[i].data());
        d.length[i] = std::sqrt(square);
        if (!(square > kDependent * whole))
            return false;
        for (double &x : d.vector[i])
            x /= d.length[i];
        return true;
    };
    d.sine_first = dot(d.vector[1].data(), d.vector[1].data()) > dot(d.vector[0].data(), d.vector[0].data());
    if (d.sine_first) {
        std::swap(d.vector[0], d.vector[1]);
        std::swap(d.along[0], d.along[1]);
    }
    if (!normalise(0))
        return d;
    for (int pass = 0; pass < 2; pass++)
        d.second_on_first += remove(d.vector[0].data(), d.vector[1].data());
    d.rank = normalise(1) ? 2 : 1;
    return d;
}

NoiseFit NoiseModel::fit(const NoiseWave &wave) const {
    const Directions d = directions(wave);
    Column rest(column(m_), column(m_) + rows_);
    NoiseFit fit = {d.rank, 0, null_residual_, 0};
    for (int i = 0; i < d.rank; i++) {
        remove(d.vector[i].data(), rest.data());
        fit.log_volume += 2 * std::log(d.length[i]);
    }
    fit.residual = dot(rest.data(), rest.data());
    for (size_t j = 0; j < m_; j++)
        fit.log_volume += 2 * std::log(triangle_[j * m_ + j]);
    return fit;
}

double NoiseModel::log_likelihood(const NoiseFit &fit) const noexcept {
    const double freedom = static_cast<double>(n_ - free_) - fit.rank;
    return -0.5 * (freedom * std::log(std::max(fit.residual, kLeastSquare)) + log_determinant_ + fit.log_volume);
}

double NoiseModel::log_profile(const NoiseFit &fit) const noexcept {
    const auto freedom = static_cast<double>(n_);
    return -0.5 * (freedom * std::log(std::max(fit.residual, kLeastSquare)) + log_determinant_);
}

void NoiseModel::back_substitute(double *right) const noexcept {
    for (size_t j = m_; j-- > 0;) {
        right[j] /= triangle_[j * m_ + j];
        for (size_t i = 0; i < j; i++)
            right[i] -= triangle_[j * m_ + i] * right[j];
    }
}

// With Q R = functions, and c = Q u + ..., s = Q v + ... for the two directions: R coefficients = Q^T y - x u - z v.
NoiseSolution NoiseModel::solve(const NoiseWave &wave, double *values, double *errors) const {
    const Directions d = directions(wave);
    Column rest(column(m_), column(m_) + rows_), coefficients = along_;
    double amount[2] = {}, x[2] = {};
    for (int i = 0; i < d.rank; i++)
        amount[i] = remove(d.vector[i].data(), rest.data());
    const double scale =
        std::sqrt(dot(rest.data(), rest.data()) / (static_cast<double>(n_ - free_) - d.rank)) * value_unit_;
    // Rows of the inverse of the triangle of the two directions.
    const double a = d.rank > 0 ? 1 / d.length[0] : 0, c = d.rank == 2 ? 1 / d.length[1] : 0;
    const double b = -a * d.second_on_first * c;
    x[0] = a * amount[0] + b * amount[1];
    x[1] = c * amount[1];
    Column g[2] = {d.along[0], d.along[1]};
    for (size_t j = 0; j < m_; j++)
        for (int i = 0; i < 2; i++)
            coefficients[j] -= x[i] * g[i][j];
    for (Column *right : {&coefficients, &g[0], &g[1]})
        back_substitute(right->data());
    for (size_t j = 0; j < m_; j++) {
        values[j] = coefficients[j] * value_unit_ / unit_[j] + (j == 0 ? archive_.first_value : 0);
        const double first = g[0][j] * a, second = g[0][j] * b + g[1][j] * c;
        errors[j] = first * first + second * second;
    }
    for (size_t k = 0; k < m_; k++) {
        Column inverse(m_);
        inverse[k] = 1;
        back_substitute(inverse.data());
        for (size_t j = 0; j < m_; j++)
            errors[j] += inverse[j] * inverse[j];
    }
    for (size_t j = 0; j < m_; j++)
        errors[j] = std::sqrt(errors[j]) * scale / unit_[j];

    const double cosine = x[d.sine_first ? 1 : 0], sine = x[d.sine_first ? 0 : 1], amplitude = std::hypot(cosine, sine);
    NoiseSolution found = {amplitude * value_unit_, kUndetermined, std::atan2(cosine, sine), kUndetermined,
                           kUndetermined};
    if (d.rank < 2 || !(amplitude > 0))
        return found;
    const double along[2] = {(d.sine_first ? sine : cosine) / amplitude, (d.sine_first ? cosine : sine) / amplitude};
    const auto error = [&](double p, double q) { return std::hypot(p * a, p * b + q * c) * scale; };
    found.amplitude_error = error(along[0], along[1]);
    found.phase_error = error(-along[1], along[0]) / found.amplitude;
    Column slope(n_), derivative(rows_), unused(m_);
    for (size_t i = 0; i < n_; i++)
        slope[i] = kTwoPi * t_high_[i] * (sine * wave.cosine[i] - cosine * wave.sine[i]);
    whiten(slope.data(), derivative.data());
    project(derivative.data(), unused.data(), m_);
    remove(d.vector[0].data(), derivative.data());
    remove(d.vector[1].data(), derivative.data());
    const double length = std::sqrt(dot(derivative.data(), derivative.data()));
    found.frequency_error = length > 0 ? scale / (length * value_unit_) : kUndetermined;
    return found;
}

bool NoiseModel::set_residuals(const double *whitened) noexcept {
    std::copy(whitened, whitened + n_, column(m_));
    std::fill(column(m_) + n_, column(m_) + rows_, 0.0);
    const double whole = dot(column(m_), column(m_));
    project(column(m_), along_.data(), m_);
    null_residual_ = dot(column(m_), column(m_));
    rho_ = kReplaced;
    return null_residual_ > kDependent * whole;
}

// Expected information of rho, with the scale of the noise unknown. At 0, where gaps below one step make it infinite,
// that of 1/sqrt(N) is taken.
double NoiseModel::rho_error() const noexcept {
    const auto n = static_cast<double>(n_);
    const double log_rho = std::log(std::max(rho_, 1 / std::sqrt(n)));
    double square = 0, with_scale = 0;
    for (size_t i = 1; i < n_; i++) {
        const double phi = std::exp(gap_[i] * log_rho), rest = -std::expm1(2 * gap_[i] * log_rho);
        const double slope = gap_[i] * std::exp((gap_[i] - 1) * log_rho);
        square += slope * slope * (1 + phi * phi) / (rest * rest);
        with_scale += slope * phi / rest;
    }
    return 1 / std::sqrt(square - 2 * with_scale * with_scale / n);
}

// Powers of eight frequencies at a time.
class NoiseModel::Scan {
  public:
    explicit Scan(const NoiseModel &model)
        : model_(model), cosine_(model.n_ * kLanes), sine_(model.n_ * kLanes), turn_(2 * model.n_),
          sums_(2 * (model.m_ + 1) * kLanes) {}

    void start(double f0, double df, size_t k);
    void advance() noexcept;
    void sum() noexcept;
    // False if the sums of a lane cancel.
    bool power(size_t lane, double &power) const noexcept;

  private:
    const NoiseModel &model_;
    Column cosine_, sine_; // [n][kLanes]
    Column turn_;          // [n][2]: rotation by kLanes df
    Column sums_;          // [m + 1][2][kLanes]: of functions and values with cosine and sine
    double cc_[kLanes], cs_[kLanes], ss_[kLanes];
};

void NoiseModel::Scan::start(double f0, double df, size_t k) {
    const double eight = kLanes * df;
    for (size_t i = 0; i < model_.n_; i++) {
        const double high = model_.t_high_[i], low = model_.t_low_[i];
        for (size_t j = 0; j < kLanes; j++)
            kernels::cis_product(f0 + static_cast<double>(k + j) * df, 0, high, low, cosine_[i * kLanes + j],
                                 sine_[i * kLanes + j]);
        kernels::cis_product(eight, 0, high, low, turn_[2 * i], turn_[2 * i + 1]);
    }
}

void NoiseModel::Scan::advance() noexcept {
    for (size_t i = 0; i < model_.n_; i++) {
        const double a = turn_[2 * i], b = turn_[2 * i + 1];
        double *const c = &cosine_[i * kLanes], *const s = &sine_[i * kLanes];
        for (size_t j = 0; j < kLanes; j++) {
            const double next = a * c[j] - b * s[j];
            s[j] = a * s[j] + b * c[j];
            c[j] = next;
        }
    }
}

void NoiseModel::Scan::sum() noexcept {
    std::fill(sums_.begin(), sums_.end(), 0.0);
    for (double *square : {cc_, cs_, ss_})
        std::fill(square, square + kLanes, 0.0);
    double before_c[kLanes] = {}, before_s[kLanes] = {}, c[kLanes], s[kLanes];
    for (size_t i = 0; i < model_.n_; i++) {
        const double own = model_.own_[i], previous = model_.previous_[i];
        const double *const cosine = &cosine_[i * kLanes], *const sine = &sine_[i * kLanes];
        for (size_t j = 0; j < kLanes; j++) {
            c[j] = own * cosine[j] - previous * before_c[j];
            s[j] = own * sine[j] - previous * before_s[j];
            before_c[j] = cosine[j];
            before_s[j] = sine[j];
            cc_[j] += c[j] * c[j];
            cs_[j] += c[j] * s[j];
            ss_[j] += s[j] * s[j];
        }
        for (size_t q = 0; q <= model_.m_; q++) {
            const double value = model_.column(q)[i];
            double *const sum = &sums_[2 * q * kLanes];
            for (size_t j = 0; j < kLanes; j++) {
                sum[j] += value * c[j];
                sum[kLanes + j] += value * s[j];
            }
        }
    }
}

// b^T M^-1 b over the residual without a sinusoid. False where the functions leave too little of cosine or sine, or of
// their difference: the sums cancel.
bool NoiseModel::Scan::power(size_t lane, double &power) const noexcept {
    const auto at = [&](size_t q, size_t sine) { return sums_[(2 * q + sine) * kLanes + lane]; };
    double cc = cc_[lane], cs = cs_[lane], ss = ss_[lane];
    const double least = kCancelled * (cc + ss);
    for (size_t q = 0; q < model_.m_; q++) {
        cc -= at(q, 0) * at(q, 0);
        cs -= at(q, 0) * at(q, 1);
        ss -= at(q, 1) * at(q, 1);
    }
    const double yc = at(model_.m_, 0), ys = at(model_.m_, 1), determinant = cc * ss - cs * cs;
    if (!(determinant > least * std::max(cc, ss) && cc > 0))
        return false;
    power =
        std::clamp((yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / (determinant * model_.null_residual_), 0.0, 1.0);
    return true;
}

void NoiseModel::powers(double f0, double df, size_t nf, double *power) const {
    Scan scan(*this);
    for (size_t k = 0; k < nf; k += kLanes) {
        if (k % (kLanes * kBlocks) == 0)
            scan.start(f0, df, k);
        else
            scan.advance();
        scan.sum();
        for (size_t j = 0; j < std::min(kLanes, nf - k); j++)
            if (!scan.power(j, power[k + j])) {
                const NoiseFit found = fit(wave(f0 + static_cast<double>(k + j) * df));
                power[k + j] = std::clamp(1 - found.residual / found.null_residual, 0.0, 1.0);
            }
    }
}

} // namespace toliman::period
