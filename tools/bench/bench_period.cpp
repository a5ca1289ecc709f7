// Measures the periodograms on one core and prints one JSON object per line. period.py runs this program and astropy,
// and prints the tables. Times are medians of processor time. Errors are against sums in long double with exact phases.
//
// Usage: bench_period FILE N F0 DF NF; FILE holds N times, values and sigmas as float64.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include <toliman/period.h>
#include <toliman/period_batch.h>

#include "base/quad.hpp"
#include "chosen_isa.hpp"
#include "kernels/push_rows.hpp"
#include "timing.hpp"

namespace {

using toliman::Quad;
using toliman::kernels::Isa;

struct Series {
    std::vector<double> t, y, sigma;
    double f0, df;
    int64_t nf;
    size_t n() const { return t.size(); }
};

struct Reference {
    std::vector<int64_t> k;
    std::vector<double> power;
    double error(const std::vector<double> &other) const { // only frequencies that `other` contains
        double worst = 0;
        for (size_t i = 0; i < k.size(); i++)
            if (static_cast<size_t>(k[i]) < other.size())
                worst = std::max(worst, std::fabs(other[static_cast<size_t>(k[i])] - power[i]));
        return worst;
    }
};

void check(toliman_status status) {
    if (status == TOLIMAN_OK)
        return;
    std::fprintf(stderr, "bench_period: %s\n", toliman_last_error());
    std::exit(1);
}

Series read(char **arguments) {
    const auto n = static_cast<size_t>(std::atoll(arguments[2]));
    Series series = {std::vector<double>(n),  std::vector<double>(n),  std::vector<double>(n),
                     std::atof(arguments[3]), std::atof(arguments[4]), std::atoll(arguments[5])};
    FILE *const file = std::fopen(arguments[1], "rb");
    for (std::vector<double> *column : {&series.t, &series.y, &series.sigma})
        if (file == nullptr || std::fread(column->data(), sizeof(double), n, file) != n) {
            std::fprintf(stderr, "bench_period: %s: cannot be read\n", arguments[1]);
            std::exit(1);
        }
    std::fclose(file);
    return series;
}

// Floating-mean power from the normal equations of 1, cosine and sine.
double exact_power(const Series &series, int64_t k) {
    const Quad f = static_cast<Quad>(series.f0) + static_cast<Quad>(k) * static_cast<Quad>(series.df);
    long double w = 0, wy = 0, c = 0, s = 0, cc = 0, cs = 0, ss = 0, yc = 0, ys = 0, yy = 0;
    const long double y0 = series.y[0];
    for (size_t i = 0; i < series.n(); i++) {
        const Quad cycles = f * static_cast<Quad>(series.t[i]);
        const auto part = static_cast<long double>(cycles - static_cast<Quad>(static_cast<int64_t>(cycles)));
        const long double angle = 6.283185307179586476925286766559L * part, cosine = std::cos(angle);
        const long double sine = std::sin(angle), sigma = series.sigma[i], weight = 1 / (sigma * sigma);
        const long double y = series.y[i] - y0;
        w += weight, wy += weight * y, yy += weight * y * y;
        c += weight * cosine, s += weight * sine;
        cc += weight * cosine * cosine, cs += weight * cosine * sine, ss += weight * sine * sine;
        yc += weight * y * cosine, ys += weight * y * sine;
    }
    cc -= c * c / w, cs -= c * s / w, ss -= s * s / w;
    yc -= wy * c / w, ys -= wy * s / w, yy -= wy * wy / w;
    return static_cast<double>((yc * yc * ss - 2 * yc * ys * cs + ys * ys * cc) / ((cc * ss - cs * cs) * yy));
}

// All frequencies if the reference takes seconds only. Otherwise: the highest power, a low frequency that every partial
// grid contains, and a dozen more.
std::vector<int64_t> compared_frequencies(const Series &series, const std::vector<double> &power) {
    std::vector<int64_t> all(power.size());
    std::iota(all.begin(), all.end(), 0);
    if (series.n() * power.size() <= 10000000)
        return all;
    std::vector<int64_t> some = {std::max_element(power.begin(), power.end()) - power.begin(), 5};
    for (int64_t i = 0; i < 12; i++)
        some.push_back((2 * i + 1) * series.nf / 24);
    return some;
}

Reference reference_of(const Series &series, const std::vector<double> &power) {
    Reference reference = {compared_frequencies(series, power), {}};
    for (int64_t k : reference.k)
        reference.power.push_back(exact_power(series, k));
    std::string text = "{\"part\": \"reference\", \"k\": [", powers;
    for (size_t i = 0; i < reference.k.size(); i++) {
        char number[40];
        std::snprintf(number, sizeof number, "%s%.17g", i > 0 ? ", " : "", reference.power[i]);
        text += (i > 0 ? ", " : "") + std::to_string(reference.k[i]);
        powers += number;
    }
    std::printf("%s], \"power\": [%s]}\n", text.c_str(), powers.c_str());
    return reference;
}

std::vector<double> batch(const Series &series, double tolerance, int64_t nf, int32_t functions = 1) {
    toliman_period_batch_options options = {};
    options.struct_size = sizeof options;
    options.tolerance = tolerance;
    options.threads = 1;
    options.trend = functions - 1;
    std::vector<double> power(static_cast<size_t>(nf));
    check(toliman_period_batch(series.f0, series.df, nf, series.t.data(), series.y.data(), series.sigma.data(),
                               series.n(), &options, power.data()));
    return power;
}

void measure_batch(const Series &series) {
    const Reference reference = reference_of(series, batch(series, 1e-13, series.nf));
    for (double tolerance : {1e-3, 1e-6, 1e-9, 1e-11, 1e-13}) {
        std::vector<double> power;
        const timing time = measure(5, 1, [&] { power = batch(series, tolerance, series.nf); });
        std::printf("{\"part\": \"batch\", \"tolerance\": %g, \"seconds\": %.6f, \"spread\": %.2g, \"error\": %.3g}\n",
                    tolerance, time.median, time.spread, reference.error(power));
    }
    // The time of direct sums is proportional to the number of frequencies: for long runs, measure a part of the grid.
    constexpr double kMost = 5e8;
    const double terms = static_cast<double>(series.n()) * static_cast<double>(series.nf);
    const auto part =
        std::max<int64_t>(16, static_cast<int64_t>(std::min(1.0, kMost / terms) * static_cast<double>(series.nf)));
    std::vector<double> power;
    const double seconds = measure(1, 1, [&] { power = batch(series, 0, part); }).median;
    std::printf("{\"part\": \"direct\", \"seconds\": %.6f, \"measured\": %g, \"error\": %.3g}\n",
                seconds * static_cast<double>(series.nf) / static_cast<double>(part),
                static_cast<double>(part) / static_cast<double>(series.nf), reference.error(power));
    // Push all samples into exact sums, then one query. The time is proportional to the number of samples.
    const auto pushed = std::min(series.n(), static_cast<size_t>(kMost / static_cast<double>(series.nf)));
    toliman_period_options options = {};
    options.struct_size = sizeof options;
    options.sigma_floor = *std::min_element(series.sigma.begin(), series.sigma.end());
    toliman_period *period = nullptr;
    check(toliman_period_create(series.f0, series.df, series.nf, &options, &period));
    power.resize(static_cast<size_t>(series.nf));
    const timing all = measure(1, 1, [&] {
        check(toliman_period_push_many(period, series.t.data(), series.y.data(), series.sigma.data(), pushed));
        check(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, power.size(), power.data()));
    });
    toliman_period_destroy(period);
    const double share = static_cast<double>(pushed) / static_cast<double>(series.n());
    std::printf("{\"part\": \"stream\", \"seconds\": %.6f, \"measured\": %g, \"error\": ", all.median / share, share);
    std::printf(pushed == series.n() ? "%.3g}\n" : "null}\n", reference.error(power));
}

// With a trend of `functions` - 1 polynomials; the error is against the same in the smallest tolerance.
void measure_batch_with_trend(const Series &series) {
    for (const int32_t functions : {1, 3, 5}) {
        std::vector<double> power;
        const timing time = measure(5, 1, [&] { power = batch(series, 1e-9, series.nf, functions); });
        const std::vector<double> exact = batch(series, 1e-13, series.nf, functions);
        double error = 0;
        for (size_t k = 0; k < power.size(); k++)
            error = std::max(error, std::fabs(power[k] - exact[k]));
        std::printf("{\"part\": \"batch_nuisance\", \"functions\": %d, \"tolerance\": 1e-9, \"seconds\": %.6f, "
                    "\"spread\": %.2g, \"error\": %.3g}\n",
                    functions, time.median, time.spread, error);
    }
}

// Hardware lower bound of a push and a query: read both words of each sum and write one.
inline __attribute__((always_inline)) void pass(uint64_t *__restrict lower, const uint64_t *__restrict upper,
                                                size_t count) {
    for (size_t i = 0; i < count; i++)
        lower[i] += upper[i];
}

#if defined(__x86_64__)
#ifdef __clang__ // which has no attribute for the width of vectors
#define AVX512 "avx512f"
#else
#define AVX512 "avx512f,prefer-vector-width=512"
#endif
__attribute__((target(AVX512))) void pass_avx512(uint64_t *lower, const uint64_t *upper, size_t count) {
    pass(lower, upper, count);
}
__attribute__((target("avx2"))) void pass_avx2(uint64_t *lower, const uint64_t *upper, size_t count) {
    pass(lower, upper, count);
}
#endif
void pass_baseline(uint64_t *lower, const uint64_t *upper, size_t count) {
    pass(lower, upper, count);
}

// Time in seconds of the fastest pass over the accumulators that this processor supports, whichever instruction set the
// library uses.
double pass_s(const Series &series, size_t sums) {
    const struct {
        Isa isa;
        void (*pass)(uint64_t *, const uint64_t *, size_t);
    } all[] = {
        {Isa::baseline, pass_baseline},
#if defined(__x86_64__)
        {Isa::avx2, pass_avx2},
        {Isa::avx512, pass_avx512},
#endif
    };
    const size_t count = static_cast<size_t>(series.nf) * sums;
    std::vector<uint64_t> lower(count), upper(count, 1);
    double least = INFINITY;
    for (const auto &one : all)
        if (toliman::kernels::runs(one.isa))
            least = std::min(least, shortest(50, 10, [&] { one.pass(lower.data(), upper.data(), count); }));
    return least;
}

size_t allocated = 0; // bytes

void *allocate(size_t size, size_t alignment, void *) {
    allocated += size;
    return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

void release(void *memory, size_t size, void *) {
    allocated -= size;
    std::free(memory);
}

// Push one frame and query the power of every frequency, with a trend of `functions` - 1 polynomials.
void measure_frame(const Series &series, bool double_limb, int32_t functions) {
    toliman_period_options options = {};
    options.struct_size = sizeof options;
    options.sigma_floor = 0.1;
    options.flags = double_limb ? TOLIMAN_PERIOD_DOUBLE_LIMB : 0;
    options.trend = functions - 1;
    options.trend_end = functions > 1 ? series.t.back() : 0;
    const toliman_allocator counting = {sizeof(toliman_allocator), 0, allocate, release, nullptr};
    options.allocator = &counting;
    toliman_period *period = nullptr;
    check(toliman_period_create(series.f0, series.df, series.nf, &options, &period));
    using namespace toliman::kernels;
    const size_t sums = double_limb ? kSums + static_cast<size_t>(functions - 1) * kFunctionSums : kSingleLimbSums;
    const double before = pass_s(series, sums);
    constexpr int kPushes = 1000;
    size_t next = 0;
    const timing push = measure(5, kPushes, [&] {
        check(toliman_period_push(period, series.t[next], series.y[next], series.sigma[next]));
        next = (next + 1) % series.n();
    });
    std::vector<double> power(static_cast<size_t>(series.nf));
    constexpr int kQueries = 100;
    const timing query = measure(5, kQueries, [&] {
        check(toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, power.size(), power.data()));
    });
    const double roofline = std::min(before, pass_s(series, sums));
    const double nf = static_cast<double>(series.nf), bytes = static_cast<double>(allocated);
    toliman_period_destroy(period);
    std::printf("{\"part\": \"%s\", \"functions\": %d, \"isa\": \"%s\", \"push_ns\": %.4f, \"query_ns\": %.4f, "
                "\"bytes\": %.1f, \"seconds\": %.9f, \"spread\": %.2g, \"roofline\": %.3g}\n",
                functions > 1 ? "nuisance"
                : double_limb ? "double_limb"
                              : "frame",
                functions, host_isa_name(), push.median / nf * 1e9, query.median / nf * 1e9, bytes / nf,
                push.median + query.median, push.spread + query.spread, roofline);
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 6) {
        std::fprintf(stderr, "Usage: bench_period FILE N F0 DF NF\n");
        return 2;
    }
    const Series series = read(argv);
    for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512}) {
        if (!toliman::kernels::runs(isa))
            continue;
        toliman::kernels::chosen = isa;
        measure_frame(series, false, 1);
        for (const int32_t functions : {1, 3, 5})
            measure_frame(series, true, functions);
    }
    measure_batch_with_trend(series);
    measure_batch(series); // with the widest instruction set
}
