// Method: three algorithms in turn, each for the frequencies at which the one before could not guarantee the tolerance.
//   1. Sums of w, of w (y - mean) and of w at 2 f by non-uniform FFTs, in O(N + nf log nf). Press and Rybicki (1989,
//      ApJ 338, 277) reduce Lomb-Scargle to these sums.
//   2. Compensated direct sums with 1 - cos in place of cos, which keep their digits where phases are small.
//   3. Double-limb exact sums (stream.cpp) where every sum of doubles cancels.
// The tolerance is guaranteed by a bound. With P = b^T M^-1 b and a = M^-1 b, errors d of b and D of M change P by at
// most 2 |a^T d| + |a^T D a|. The bound holds for the worst times and values, so that typical errors are far smaller.
// Measured (10^3 samples, 10^4 frequencies, one AVX-512 core): FFT at 1e-9 0.001 s, direct sums 0.029 s, exact sums
// 0.02 s. The FFT is the fastest from about 100 samples and frequencies. Larger sizes: tools/docs/benchmarks.md.
#include "period/batch/batch.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "base/error.hpp"
#include "base/workers.hpp"
#include "kernels/direct.hpp"
#include "period/batch/archive_basis.hpp"
#include "period/batch/nufft.hpp"
#include "period/stream/power.hpp"

namespace toliman::period {

namespace {

using kernels::kDirectLanes;

// Cost model for the choice between FFT and direct sums, in ns on an AVX-512 core: per sample and frequency; per sample
// spread onto three pairs of grids; per cell transformed.
constexpr double kDirectCost = 4.2, kSpreadCost = 57, kCellCost = 80;
// Error of a direct sum, relative to the sum of |terms|; includes the rounding of the prepared samples.
constexpr double kDirectError = 4e-15;
// Rounding error of the solution of the 2 x 2 equations in double, times their determinant.
constexpr double kSolveError = 5e-16;
constexpr double kUnsolved = -1; // in place of a power that does not meet the tolerance

class Batch {
  public:
    Batch(const BatchJob &job, const Archive &archive, double *power)
        : job_(job), archive_(archive), power_(power), nf_(static_cast<size_t>(job.grid.nf)),
          workers_(worker_count(job.threads)) {}

    void run() {
        const Nufft::Choice choice = Nufft::choose(nf_, job_.tolerance / 4);
        const auto n = static_cast<double>(archive_.n), nf = static_cast<double>(nf_);
        const bool rows = job_.grid.basis.any(); // no direct sums
        const bool direct =
            job_.tolerance < kMinTolerance ||
            (!rows && kDirectCost * n * nf < kSpreadCost * n + kCellCost * static_cast<double>(choice.cells));
        std::fill(power_, power_ + nf_, kUnsolved);
        if (!direct && rows)
            by_nufft(choice, ArchiveBasis(archive_, job_.grid.basis));
        else if (!direct)
            by_nufft(choice);
        if (!rows)
            by_direct_sums();
        by_exact_sums();
    }

  private:
    using Complex = std::complex<double>;
    void by_nufft(const Nufft::Choice &choice);
    void by_nufft(const Nufft::Choice &choice, const ArchiveBasis &basis);
    template <class Solve>
    void transform(const Nufft &nufft, const std::vector<const double *> &columns, const Solve &solve);
    double rows_power(const ArchiveBasis &basis, const Complex *sums, double error) const noexcept;
    double nufft_power(const std::complex<double> &w, const std::complex<double> &x, const std::complex<double> &w2,
                       double error) const noexcept;
    void by_direct_sums();
    double direct_power(const double *high, const double *low) const noexcept;
    void by_exact_sums();
    Stream exact_stream(Grid grid, const std::function<void(double)> &report) const;
    double exact_power(const Stream &stream, size_t k) const;
    std::vector<size_t> unsolved() const;
    void frequency(double k, double &high, double &low) const noexcept;
    double tolerance() const noexcept { return std::max(job_.tolerance, kMinTolerance); }
    void for_all(const char *stage, size_t jobs, const std::function<void(size_t)> &work) const {
        run_jobs(workers_, jobs, work, [&](double fraction) { job_.progress.report(stage, fraction); });
    }

    const BatchJob &job_;
    const Archive &archive_;
    double *power_;
    size_t nf_;
    unsigned workers_;
};

// f0 + k df as an unevaluated sum.
void Batch::frequency(double k, double &high, double &low) const noexcept {
    const double f0 = job_.grid.f0, df = job_.grid.df, step = df * k, step_error = std::fma(df, k, -step);
    high = f0 + step;
    const double back = high - f0;
    low = (f0 - (high - back)) + (step - back) + step_error;
}

// Sums of all columns at f and of w at 2 f, each on a pair of grids. Calls solve(sums) for each frequency.
template <class Solve>
void Batch::transform(const Nufft &nufft, const std::vector<const double *> &columns, const Solve &solve) {
    const size_t count = columns.size(), passes = (count + 1) / 2, grid_count = 2 * (count + 1);
    std::vector<Buffer<double>> grids(grid_count);
    std::vector<double *> at(grid_count);
    for (size_t g = 0; g < grid_count; g++) {
        grids[g].resize(nufft.grid_size());
        at[g] = grids[g].data();
    }
    double high, low;
    const auto middle = nf_ / 2;
    frequency(static_cast<double>(middle), high, low);
    const double df = job_.grid.df;
    for_all("spread", passes + 1, [&](size_t pass) {
        const bool twice = pass == passes;
        const double times = twice ? 2 : 1;
        const size_t first = 2 * pass, pairs = twice ? 1 : std::min<size_t>(2, count - first);
        nufft.spread({archive_.t_high.data(),
                      archive_.t_low.data(),
                      {twice ? archive_.w.data() : columns[first], pairs == 2 ? columns[first + 1] : nullptr},
                      archive_.n},
                     times * df, times * high, times * low, pairs, at.data() + (twice ? 2 * count : 2 * first));
    });
    for_all("transform", grid_count, [&](size_t g) { nufft.transform(at[g]); });
    constexpr size_t kPart = 4096;
    for_all("solve", (nf_ + kPart - 1) / kPart, [&](size_t part) {
        Complex sums[kMaxFunctions + 2];
        for (size_t k = part * kPart; k < std::min(nf_, (part + 1) * kPart); k++) {
            for (size_t i = 0; i <= count; i++)
                sums[i] = nufft.sum(at[2 * i], at[2 * i + 1], k);
            power_[k] = solve(sums);
        }
    });
}

void Batch::by_nufft(const Nufft::Choice &choice) {
    const Nufft nufft(choice);
    transform(nufft, {archive_.w.data(), archive_.x.data()},
              [&](const Complex *sums) { return nufft_power(sums[0], sums[1], sums[2], nufft.error()); });
}

void Batch::by_nufft(const Nufft::Choice &choice, const ArchiveBasis &basis) {
    if (!(basis.error <= job_.tolerance))
        return;
    const Nufft nufft(choice);
    std::vector<const double *> columns;
    for (const Buffer<double> &function : basis.functions)
        columns.push_back(function.data());
    columns.push_back(basis.x.data());
    transform(nufft, columns, [&](const Complex *sums) { return rows_power(basis, sums, nufft.error()); });
}

// nufft_power with orthonormal functions: sums of the functions, of x, and of w at 2 f.
double Batch::rows_power(const ArchiveBasis &basis, const Complex *sums, double error) const noexcept {
    const Complex x = sums[basis.used()], w2 = sums[basis.used() + 1];
    double cc = 0.5 + 0.5 * w2.real(), ss = 0.5 - 0.5 * w2.real(), cs = 0.5 * w2.imag(), functions = 0;
    for (size_t f = 0; f < basis.used(); f++) {
        const double c = sums[f].real(), s = sums[f].imag();
        cc -= c * c;
        ss -= s * s;
        cs -= c * s;
        functions += std::fabs(c) + std::fabs(s);
    }
    const double determinant = cc * ss - cs * cs, part = 1 / determinant, each = error + basis.error;
    const double a = (x.real() * ss - x.imag() * cs) * part, b = (x.imag() * cc - x.real() * cs) * part;
    const double size = std::fabs(a) + std::fabs(b);
    const double bound = each * size * (2 * basis.largest_sum + size * (0.5 + 2 * functions)) + kSolveError * part;
    const bool good = determinant > 100 * each && bound <= job_.tolerance && archive_.n > basis.free + 2;
    return good ? std::clamp(a * x.real() + b * x.imag(), 0.0, 1.0) : kUnsolved;
}

// Returns the power, or kUnsolved if an error of `error` in each sum may change it by more than the tolerance.
double Batch::nufft_power(const std::complex<double> &w, const std::complex<double> &x, const std::complex<double> &w2,
                          double error) const noexcept {
    const double moving = job_.grid.fixed_mean ? 0.0 : 1.0, c = moving * w.real(), s = moving * w.imag();
    const double cc = 0.5 + 0.5 * w2.real() - c * c, ss = 0.5 - 0.5 * w2.real() - s * s, cs = 0.5 * w2.imag() - c * s;
    const double determinant = cc * ss - cs * cs, part = 1 / determinant;
    const double a = (x.real() * ss - x.imag() * cs) * part, b = (x.imag() * cc - x.real() * cs) * part;
    const double size = std::fabs(a) + std::fabs(b);
    const double bound = error * size * (2 * archive_.largest_sum + size * (0.5 + 2 * (std::fabs(c) + std::fabs(s)))) +
                         kSolveError * part;
    // The determinant must exceed its own error by far. Up to three samples, with as many parameters, are left to
    // explained_share().
    const bool good = determinant > 100 * error && bound <= job_.tolerance && archive_.n > 3;
    return good ? std::clamp(a * x.real() + b * x.imag(), 0.0, 1.0) : kUnsolved;
}

std::vector<size_t> Batch::unsolved() const {
    std::vector<size_t> found;
    for (size_t k = 0; k < nf_; k++)
        if (power_[k] == kUnsolved)
            found.push_back(k);
    return found;
}

void Batch::by_direct_sums() {
    const std::vector<size_t> wanted = unsolved();
    for_all("sum", (wanted.size() + kDirectLanes - 1) / kDirectLanes, [&](size_t part) {
        const size_t begin = part * kDirectLanes, count = std::min(kDirectLanes, wanted.size() - begin);
        double half_high[kDirectLanes], half_low[kDirectLanes];
        for (size_t j = 0; j < kDirectLanes; j++) {
            frequency(static_cast<double>(wanted[begin + std::min(j, count - 1)]), half_high[j], half_low[j]);
            half_high[j] *= 0.5;
            half_low[j] *= 0.5;
        }
        double high[kernels::kDirectSums * kDirectLanes] = {}, low[kernels::kDirectSums * kDirectLanes] = {};
        kernels::direct_kernels().direct(
            half_high, half_low,
            {archive_.t_high.data(), archive_.t_low.data(), archive_.w.data(), archive_.x.data(), archive_.n}, high,
            low);
        for (size_t j = 0; j < count; j++)
            power_[wanted[begin + j]] = direct_power(high + j, low + j);
    });
}

// Returns the power from sums of u = 1 - cos and v = sin, which keep their digits for small phases, or kUnsolved. The
// error bound is that of nufft_power with errors relative to the magnitude of the terms, doubled. It requires that the
// sign of the determinant, and hence the rank, is certain.
double Batch::direct_power(const double *high, const double *low) const noexcept {
    using namespace kernels;
    const auto sum = [&](DirectSum i) {
        return static_cast<long double>(high[i * kDirectLanes]) + low[i * kDirectLanes];
    };
    const bool fixed_mean = job_.grid.fixed_mean;
    const long double u = sum(kU), v = sum(kV), uu = sum(kUU), uv = sum(kUV), vv = sum(kVV);
    Moments<long double> m = {uu - u * u, u * v - uv, vv - v * v, -sum(kXU), sum(kXV), 0};
    if (fixed_mean) {
        m.cc = 1 - 2 * u + uu;
        m.cs = v - uv;
        m.ss = vv;
    }
    m.determinant = m.cc * m.ss - m.cs * m.cs;
    const long double both = m.cc + m.ss, size_c = std::sqrt(fixed_mean ? 1 : uu), size_s = std::sqrt(vv);
    const long double error_root = size_c * std::sqrt(m.ss) + size_s * std::sqrt(m.cc);
    const long double error = kDirectError * error_root * error_root;
    const bool rank_is_certain = error <= m.determinant / 4 || m.determinant + error <= kCoincident * both * both / 2;
    const Solved solved = solve(m, kCoincident * both);
    const long double size = std::fabs(solved.cosine) * size_c + std::fabs(solved.sine) * size_s;
    const bool good = rank_is_certain && 2 * kDirectError * (2 * size + size * size) <= tolerance();
    return good ? explained_share(solved, 1, fixed_mean ? 0 : 1, static_cast<int64_t>(archive_.n)) : kUnsolved;
}

// Frequencies at which any sum of doubles cancels: exact sums of all samples, at these frequencies alone if they are
// few.
void Batch::by_exact_sums() {
    const std::vector<size_t> wanted = unsolved();
    if (wanted.empty())
        return;
    const char *const stage = "exact sums";
    Grid grid = job_.grid;
    if (wanted.size() * kernels::kBlock > wanted.back()) {
        grid.nf = static_cast<int64_t>(wanted.back()) + 1;
        const Stream stream = exact_stream(grid, [&](double part) { job_.progress.report(stage, part); });
        for (size_t k : wanted)
            power_[k] = exact_power(stream, k);
    } else {
        for_all(stage, wanted.size(), [&](size_t i) {
            double high, low;
            frequency(static_cast<double>(wanted[i]), high, low);
            Grid alone = grid; // two frequencies, the second of which is high + low exactly
            alone.f0 = std::nextafter(high, 0);
            alone.df = (high - alone.f0) + low;
            alone.nf = 2;
            power_[wanted[i]] = exact_power(exact_stream(alone, nullptr), 1);
        });
    }
}

Stream Batch::exact_stream(Grid grid, const std::function<void(double)> &report) const {
    const double value_scale = archive_.value_scale, sigma_scale = archive_.sigma_scale;
    grid.time_offset = archive_.reference;
    grid.value_offset = archive_.first_value * value_scale;
    grid.value_bound = archive_.value_bound * value_scale;
    if (grid.basis.precision[0] > 0) { // the prior of the mean is about value_offset
        grid.value_bound += std::fabs(grid.value_offset);
        grid.value_offset = 0;
    }
    grid.sigma_floor = archive_.least_sigma * sigma_scale;
    // Double-limb accumulators in any case: single-limb terms have the errors of double.
    grid.sigma_ceiling = std::max(archive_.most_sigma * sigma_scale, 2 * kSingleLimbSigmaRatio * grid.sigma_floor);
    for (double &precision : grid.basis.precision)
        precision = precision / sigma_scale / sigma_scale; // the square may overflow
    Stream stream(grid);
    const BatchSamples &samples = archive_.samples;
    for (size_t i = 0; i < samples.n; i++) {
        const double sigma = samples.sigma != nullptr ? samples.sigma[i] * sigma_scale : grid.sigma_floor;
        Sample sample = stream.sample(samples.t[i], 0, samples.y[i] * value_scale, sigma);
        sample.columns = samples.columns + i * static_cast<size_t>(grid.basis.columns);
        stream.check(sample, static_cast<int64_t>(i));
        stream.push(sample);
        if (report && i % 1024 == 0)
            report(static_cast<double>(i) / static_cast<double>(samples.n));
    }
    return stream;
}

double Batch::exact_power(const Stream &stream, size_t k) const {
    // The limit of direct sums, where there are any.
    const PowerQuery query = stream.grid().basis.any() ? PowerQuery(stream) : PowerQuery(stream, kCoincident);
    query.check();
    return query.at(static_cast<int64_t>(k));
}

} // namespace

void batch_power(const BatchJob &job, const BatchSamples &samples, double *power) {
    if (!(job.tolerance >= 0 && job.tolerance <= kMaxTolerance))
        fail(Status::range, "{tolerance} = %g: must be in [0, %g]", job.tolerance, kMaxTolerance);
    BatchJob known = job;
    known.grid.sigma_ceiling = known.grid.sigma_floor;
    complete(known.grid.basis, samples);
    known.grid.check();
    const auto nf = static_cast<size_t>(known.grid.nf);
    const Archive archive(samples, known.grid.last());
    Buffer<double> result(nf);
    if (!archive.constant())
        Batch(known, archive, result.data()).run();
    std::copy(result.begin(), result.end(), power);
}

} // namespace toliman::period
