// Method: the functions b_1 ... b_K, the mean among them, are projected out by the Schur complement of the normal
// equations. With the Gram matrix G = L L^T and u_x = L^-1 (sum w b x) for x = cosine, sine and y, every moment becomes
//     sum w x z - u_x . u_z
// and the sinusoid is solved from these as with the mean alone. The power is 1 - R/R_H with the residual R_H of the
// functions alone, not of the mean: a trend that the functions describe is not counted as unexplained. A prior of
// precision p adds p to the diagonal of G, and to nothing else.
// L is the Cholesky factor in 113 bits. A function whose pivot is below 2^-80 of its diagonal is left out: it differs
// from those before it by what rounding leaves. Polynomials come in order, so that few samples, or samples of a short
// part of the span, drop the highest orders.
//
// Precision: a vectorised kernel in double where it keeps 12 digits, long double where 14 of its 19 digits remain, 113
// bits where more cancel: samples of a small part of the span of the trend or of a cycle.
//
// Rejected: subtracting a fitted trend from the values first. It removes a part of the signal that the fit of both
// keeps: log10 FAP -5.9, -3.1, -0.1 instead of -7.9, -5.8, -2.9 for periods of 0.27, 0.39, 0.44 of the time span.
//
// Reference: Golub and Van Loan, Matrix Computations, section 4.2 (Cholesky).
#include "period/stream/projection.hpp"

#include <cmath>
#include <iterator>
#include <limits>
#include <type_traits>

namespace toliman::period {

namespace {

constexpr Quad kLeastPivot = static_cast<Quad>(0x1p-80);          // of its diagonal
constexpr Quad kLeastSpread = static_cast<Quad>(0x1p-96);         // of the sum of squares
constexpr long double kAccuratePivot = 1e-4L, kFarSpread = 1e-6L; // below which 64 bits do not suffice

template <class Real, class Vector> Real dot(const Vector &a, const Vector &b, size_t n) noexcept {
    Real sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

// Sum of the magnitudes of coefficients, which bounds the function that they describe.
long double size(const std::array<Quad, kMaxFunctions> &coefficients, size_t n) noexcept {
    long double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += std::fabs(static_cast<long double>(coefficients[i]));
    return sum;
}

} // namespace

template <class Real> const Projection::Factor<Real> &Projection::factor() const noexcept {
    if constexpr (std::is_same_v<Real, Quad>)
        return quad_;
    else
        return long_double_;
}

Projection::Projection(const Stream &stream) noexcept : stream_(stream), part_(0) {
    const Totals &totals = stream.totals();
    const Quad weight = totals.w.value();
    if (!(weight > 0))
        return;
    part_ = 1 / weight;
    decompose(stream.basis_sums());
    Vector<Quad> sums = {};
    sums[0] = totals.wy.value();
    for (size_t f = 1; f < stream.basis_sums().functions(); f++)
        sums[f] = stream.basis_sums().with_y(f).value();
    quad_.y = solve_forward<Quad>(sums.data());
    const Quad square = totals.wyy.value() * part_, spread = square - dot<Quad>(quad_.y, quad_.y, used_);
    if (spread > kLeastSpread * square)
        spread_ = static_cast<long double>(spread);
    needs_quad_ = needs_quad_ || spread_ < kFarSpread * static_cast<long double>(square);
    for (size_t i = 0; i < used_; i++) {
        for (size_t j = 0; j <= i; j++)
            long_double_.l[i][j] = static_cast<long double>(quad_.l[i][j]);
        long_double_.inverse[i] = static_cast<long double>(quad_.inverse[i]);
        long_double_.y[i] = static_cast<long double>(quad_.y[i]);
    }
    set_inverse();
    samples_over_weight_ = static_cast<long double>(totals.count) * static_cast<long double>(part_);
    set_shared(square);
    value_size_ = (1 + size(solve_back(quad_.y), used_)) / std::sqrt(spread_);
}

// Double suffices where a function keeps a tenth of its size, and the values a 300th of theirs: errors below 1e-12.
void Projection::set_shared(Quad square) noexcept {
    constexpr double kLeastDiagonal = 0.1, kLeastShare = 1e-5;
    shared_.weight = static_cast<double>(1 / part_);
    shared_.samples = stream_.totals().count;
    shared_.size = std::sqrt(static_cast<double>(square));
    shared_.spread = static_cast<double>(spread_);
    shared_.used = used_;
    vectorisable_ = shared_.spread > kLeastShare * shared_.size * shared_.size && shared_.samples < int64_t{1} << 32;
    for (size_t i = 0; i < used_; i++) {
        shared_.function[i] = index_[i];
        for (size_t j = 0; j < i; j++)
            shared_.factor[i][j] = static_cast<double>(quad_.l[i][j]);
        shared_.inverse[i] = static_cast<double>(quad_.inverse[i]);
        shared_.y[i] = static_cast<double>(quad_.y[i]);
        const double square_of_row = static_cast<double>(dot<Quad>(quad_.l[i], quad_.l[i], i + 1));
        vectorisable_ = vectorisable_ && static_cast<double>(quad_.l[i][i]) > kLeastDiagonal * std::sqrt(square_of_row);
    }
}

static_assert(kMaxFunctions <= kernels::kMaxRows, "the kernels take all functions");

size_t Projection::range(int64_t first, size_t count, double *power) const noexcept {
    const int64_t *lo[kernels::kSums + (kMaxFunctions - 1) * kernels::kFunctionSums], *hi[std::size(lo)];
    for (size_t sum = 0; sum < stream_.grid().sums(); sum++) {
        lo[sum] = stream_.low(sum, first);
        hi[sum] = stream_.high(sum, first);
    }
    return kernels::power_rows_kernels().power(lo, hi, count, shared_, power);
}

Quad Projection::precision(size_t f) const noexcept {
    const Grid &grid = stream_.grid();
    const Quad ratio = static_cast<Quad>(grid.sigma_floor) / static_cast<Quad>(grid.basis.unit(f));
    return static_cast<Quad>(grid.basis.precision[f]) * ratio * ratio;
}

void Projection::decompose(const BasisSums &sums) noexcept {
    const Basis &basis = stream_.grid().basis;
    for (size_t f = 0; f < basis.functions(); f++) {
        const bool is_trend = f < basis.first_column();
        if (is_trend && f > used_) // a lower order was left out
            continue;
        Vector<Quad> products = {}; // with the functions before f
        for (size_t j = 0; j < f; j++)
            products[j] = sums.product(f, j).value();
        Vector<Quad> row = solve_forward<Quad>(products.data());
        const Quad prior = precision(f) * part_;
        const Quad square = f == 0 ? 1 : sums.product(f, f).value() * part_;
        add_function(f, square + prior, prior, row);
    }
}

void Projection::add_function(size_t f, Quad diagonal, Quad prior, Vector<Quad> &row) noexcept {
    const Quad pivot = diagonal - dot<Quad>(row, row, used_);
    const bool determined = pivot > kLeastPivot * diagonal;
    if (!(determined || (prior > 0 && 2 * pivot > prior)))
        return;
    row[used_] = root(pivot);
    quad_.l[used_] = row;
    quad_.inverse[used_] = 1 / row[used_];
    index_[used_++] = f;
    free_ += prior > 0 ? 0 : 1;
    needs_quad_ = needs_quad_ || static_cast<long double>(pivot) < kAccuratePivot * static_cast<long double>(diagonal);
}

void Projection::set_inverse() noexcept {
    for (size_t j = 0; j < used_; j++)
        for (size_t i = j; i < used_; i++) {
            Quad sum = i == j ? 1 : 0;
            for (size_t k = j; k < i; k++)
                sum -= quad_.l[i][k] * inverse_[k][j];
            inverse_[i][j] = sum * quad_.inverse[i];
        }
}

// L^-1 of the sums of all functions with some x, divided by W.
template <class Real> Projection::Vector<Real> Projection::solve_forward(const Real *sums) const noexcept {
    const Factor<Real> &known = factor<Real>();
    const Real part = static_cast<Real>(part_);
    Vector<Real> u = {};
    for (size_t i = 0; i < used_; i++) {
        Real sum = sums[index_[i]] * part;
        for (size_t j = 0; j < i; j++)
            sum -= known.l[i][j] * u[j];
        u[i] = sum * known.inverse[i];
    }
    return u;
}

Projection::Vector<Quad> Projection::solve_back(const Vector<Quad> &x) const noexcept {
    Vector<Quad> out = {};
    for (size_t j = 0; j < used_; j++)
        for (size_t i = j; i < used_; i++)
            out[j] += inverse_[i][j] * x[i];
    return out;
}

// Errors of the sums, 2^-98 per sample and 2^-104 of their size, times the coefficients of the functions in cosine,
// sine and y. In long double the error is that of 64 bits, with coefficients of order 1.
template <class Real>
void Projection::set_noise(const Vector<Real> &c, const Vector<Real> &s, Moments<Real> &m) const noexcept {
    if constexpr (std::is_same_v<Real, Quad>) {
        const long double sine = size(solve_back(s), used_), wave = 1 + size(solve_back(c), used_) + sine;
        const long double unit = samples_over_weight_ * 0x1p-98L;
        m.noise = wave * (unit + wave * 0x1p-104L);
        m.value_noise = unit * (wave + value_size_) + 0x1p-104L * wave * value_size_;
    } else {
        m.noise = m.value_noise = 0x1p-58L;
    }
}

// Moments over the sum W of the weights, part = 1/W. As cos^2 x = (1 + cos 2x)/2, sin^2 x = (1 - cos 2x)/2 and
// cos x sin x = sin 2x/2, with C2 and S2 the sums of w cos 2x and w sin 2x:
//     cc = (1 + C2/W)/2 - u_c . u_c,  ss = (1 - C2/W)/2 - u_s . u_s,  cs = S2/(2 W) - u_c . u_s.
// suffices: false if the functions take nearly all of cosine or sine, or the two coincide, so that Real has too few
// digits.
template <class Real> Moments<Real> Projection::moments(int64_t k, bool &suffices) const noexcept {
    constexpr auto kKept = static_cast<Real>(1e-5);
    Vector<Real> c = {}, s = {};
    stream_.function_sums<Real>(k, c.data(), s.data());
    const SumsAt<Real> sums = stream_.sums<Real>(k);
    const Vector<Real> uc = solve_forward<Real>(c.data()), us = solve_forward<Real>(s.data());
    const Real part = static_cast<Real>(part_), half = static_cast<Real>(0.5), c2 = sums.c2 * part * half;
    const Vector<Real> &uy = factor<Real>().y;
    Moments<Real> m = {};
    m.cc = (half + c2) - dot<Real>(uc, uc, used_);
    m.ss = (half - c2) - dot<Real>(us, us, used_);
    m.cs = sums.s2 * part * half - dot<Real>(uc, us, used_);
    m.yc = sums.yc * part - dot<Real>(uc, uy, used_);
    m.ys = sums.ys * part - dot<Real>(us, uy, used_);
    m.determinant = m.cc * m.ss - m.cs * m.cs;
    suffices = m.cc > kKept && m.ss > kKept && m.determinant > kKept * (m.cc + m.ss);
    set_noise(uc, us, m);
    return m;
}
template Moments<long double> Projection::moments(int64_t, bool &) const noexcept;
#ifdef TOLIMAN_QUAD_IS_WIDER
template Moments<Quad> Projection::moments(int64_t, bool &) const noexcept;
#endif

// With the coefficients h of cosine and sine, those of the functions are L^-T (u_y - h_c u_c - h_s u_s). Their
// covariance is G^-1 + D M^-1 D^T with D = L^-T (u_c, u_s) and the moments M of cosine and sine.
void Projection::coefficients(int64_t k, const Solved &sinusoid, long double scale, Coefficients &out) const noexcept {
    const Grid &grid = stream_.grid();
    bool suffices;
    const Moments<Quad> m = moments<Quad>(k, suffices);
    Vector<Quad> c = {}, s = {};
    stream_.function_sums<Quad>(k, c.data(), s.data());
    c = solve_forward<Quad>(c.data());
    s = solve_forward<Quad>(s.data());
    const Quad a = static_cast<Quad>(sinusoid.cosine), b = static_cast<Quad>(sinusoid.sine);
    Vector<Quad> rest = {};
    for (size_t i = 0; i < used_; i++)
        rest[i] = quad_.y[i] - a * c[i] - b * s[i];
    rest = solve_back(rest);
    c = solve_back(c);
    s = solve_back(s);
    for (size_t f = 0; f < grid.basis.functions(); f++) {
        out.value[f] = f == 0 ? grid.value_offset : 0;
        out.error[f] = std::numeric_limits<double>::infinity();
    }
    for (size_t j = 0; j < used_; j++) {
        Quad variance = 0;
        for (size_t i = j; i < used_; i++)
            variance += inverse_[i][j] * inverse_[i][j];
        const Quad along = a * c[j] + b * s[j];
        if (sinusoid.rank == 2)
            variance += (c[j] * c[j] * m.ss - 2 * c[j] * s[j] * m.cs + s[j] * s[j] * m.cc) / m.determinant;
        else if (sinusoid.rank == 1 && along != 0) // only this direction is fitted
            variance += along * along / (a * a * m.cc + 2 * a * b * m.cs + b * b * m.ss);
        const size_t f = index_[j];
        const long double unit = static_cast<long double>(grid.value_bound) / grid.basis.unit(f);
        out.value[f] = static_cast<double>(out.value[f] + unit * static_cast<long double>(rest[j]));
        out.error[f] = static_cast<double>(unit * std::sqrt(scale * static_cast<long double>(variance)));
    }
}

} // namespace toliman::period
