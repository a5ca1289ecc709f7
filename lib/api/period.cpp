// include/toliman/period.h
#include <toliman/period.h>

#include "api/common.hpp"
#include "api/grid_flags.hpp"
#include "api/handles.hpp"
#include "api/peak.hpp"
#include "api/period_samples.hpp"
#include "backend/file.hpp"
#include "period/peak.hpp"
#include "period/stream/power.hpp"
#include "period/suggest.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

period::Basis basis_of(const toliman_period_options &options) {
    period::Basis basis;
    TOLIMAN_COPY(basis, options, trend, columns);
    basis.start = options.trend_start;
    basis.end = options.trend_end;
    std::copy_n(options.column_bound, basis.bound.size(), basis.bound.begin());
    std::copy_n(options.prior_precision, basis.precision.size(), basis.precision.begin());
    for (size_t c = 0; c < basis.bound.size() && static_cast<int64_t>(c) < basis.columns; c++)
        if (basis.bound[c] == 0)
            basis.bound[c] = 1;
    return basis;
}

period::Grid grid_of(double f0, double df, int64_t nf, const toliman_period_options &options) {
    period::Grid grid;
    grid.f0 = f0;
    grid.df = df;
    grid.nf = nf;
    set_flags(grid, options.flags);
    TOLIMAN_COPY(grid, options, time_offset, time_offset_ns, value_offset, unit_ns, value_bound, sigma_floor);
    grid.sigma_ceiling =
        options.sigma_ceiling != 0 ? options.sigma_ceiling : period::kSingleLimbSigmaRatio * grid.sigma_floor;
    grid.basis = basis_of(options);
    return grid;
}

// The caller's samples with the values of their columns; a check of the stream refuses missing ones.
Structs structs(const toliman_period *period, const toliman_period_sample *samples, const double *rows, size_t n) {
    const Use use(period, "period");
    const auto width = static_cast<size_t>(use->stream.grid().basis.columns);
    if (rows != nullptr && width > 0)
        required_array(rows, checked_product(n, width, "rows"), sizeof *rows, "rows");
    return {samples, n, width > 0 ? rows : nullptr};
}

// Converts a power from the standard normalisation to another. 1 - P is resolved to about 1e-15, which bounds the
// result.
double normalised(double power, int32_t normalisation, double half_chi_square) noexcept {
    constexpr double kLeastResidual = 1e-15;
    const double residual = std::max(kLeastResidual, 1 - power);
    return normalisation == TOLIMAN_PERIOD_POWER_MODEL ? power / residual
           : normalisation == TOLIMAN_PERIOD_POWER_LOG ? -std::log(residual)
                                                       : power * half_chi_square;
}

} // namespace

extern "C" {

toliman_status toliman_period_create(double f0, double df, int64_t nf, const toliman_period_options *options,
                                     toliman_period **out) noexcept {
    return guard([&] {
        required(out, "out");
        const toliman_period_options known = accept(options, "options");
        const MemoryScope scope(memory_of(known.allocator));
        const period::Grid grid = grid_of(f0, df, nf, known);
        in_struct("options->", [&] { grid.check_options(); });
        *out = new toliman_period{{}, period::Stream(grid)};
    });
}

toliman_status toliman_period_suggest(const double *t, const double *y, const double *sigma, size_t n,
                                      double mission_span, double *f0, double *df, int64_t *nf,
                                      toliman_period_options *options) noexcept {
    return guard([&] {
        required_array(t, n, sizeof *t, "t");
        const bool only_options = f0 == nullptr && df == nullptr && nf == nullptr;
        const period::Samples samples = {t, y, sigma, n};
        const period::Grid grid =
            only_options ? period::suggest_bounds(samples, mission_span) : period::suggest(samples, mission_span);
        toliman_period_options suggested = {};
        suggested.flags = flags_of(grid);
        TOLIMAN_COPY(suggested, grid, time_offset, value_offset, value_bound, sigma_floor, sigma_ceiling);
        if (!only_options) {
            required(f0, "f0");
            required(df, "df");
            required(nf, "nf");
        }
        if (options != nullptr)
            deliver(suggested, options, "options");
        if (only_options)
            return;
        *f0 = grid.f0;
        *df = grid.df;
        *nf = grid.nf;
    });
}

void toliman_period_destroy(toliman_period *period) noexcept {
    destroy(period);
}

toliman_status toliman_period_push(toliman_period *period, double t, double y, double sigma) noexcept {
    return guard([&] { push_all(period, Arrays{&t, &y, &sigma, 1}); });
}

toliman_status toliman_period_push_many(toliman_period *period, const double *t, const double *y, const double *sigma,
                                        size_t n) noexcept {
    return guard([&] { push_all(period, Arrays{t, y, sigma, n}); });
}

toliman_status toliman_period_push_samples(toliman_period *period, const toliman_period_sample *samples,
                                           const double *rows, size_t n) noexcept {
    return guard([&] { push_all(period, structs(period, samples, rows, n)); });
}

toliman_status toliman_period_retract_samples(toliman_period *period, const toliman_period_sample *samples,
                                              const double *rows, size_t n) noexcept {
    return guard([&] { retract_all(period, structs(period, samples, rows, n)); });
}

toliman_status toliman_period_merge(toliman_period *period, const toliman_period *other) noexcept {
    return call(period, "period", [&](auto &self) {
        period::Stream &stream = self.stream;
        if (period == other)
            fail(Status::argument, "{other}: must not be the periodogram itself");
        const Use use_other(other, "other");
        stream.merge(use_other->stream);
    });
}

toliman_status toliman_period_copy(const toliman_period *period, toliman_period **out) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        required(out, "out");
        const MemoryScope scope(stream.memory());
        *out = new toliman_period{{}, stream};
    });
}

toliman_status toliman_period_get_info(const toliman_period *period, toliman_period_info *out) noexcept {
    return query(period, "period", out, [&](auto &self, auto &info) {
        const period::Stream &stream = self.stream;
        const period::Grid &grid = stream.grid();
        info.flags = flags_of(grid);
        TOLIMAN_COPY(info, grid, nf, f0, df, time_offset, value_offset, value_bound, sigma_floor, sigma_ceiling);
        TOLIMAN_COPY(info, grid, time_offset_ns, unit_ns);
        info.count = stream.totals().count;
        info.weighted = stream.weighted() ? 1 : 0;
        info.digest = grid.digest();
        TOLIMAN_COPY(info, grid.basis, trend, columns);
        info.trend_start = grid.basis.start;
        info.trend_end = grid.basis.end;
        std::copy(grid.basis.bound.begin(), grid.basis.bound.end(), info.column_bound);
        std::copy(grid.basis.precision.begin(), grid.basis.precision.end(), info.prior_precision);
        const period::Projection projection(stream);
        info.functions = static_cast<int32_t>(projection.used());
        info.free_functions = static_cast<int32_t>(projection.free());
    });
}

toliman_status toliman_period_query_power(const toliman_period *period, int32_t normalisation, int64_t first,
                                          size_t count, double *power) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        required(power, "power");
        if (normalisation < TOLIMAN_PERIOD_POWER_STANDARD || normalisation > TOLIMAN_PERIOD_POWER_PSD)
            fail(Status::argument, "{normalisation} = %d: must be one of TOLIMAN_PERIOD_POWER_..., %d to %d",
                 normalisation, TOLIMAN_PERIOD_POWER_STANDARD, TOLIMAN_PERIOD_POWER_PSD);
        const int64_t nf = stream.grid().nf;
        if (first < 0 || first > nf || count > static_cast<size_t>(nf - first))
            fail(Status::range, "{first} = %lld, count = %zu: must be within the grid of %lld frequencies",
                 static_cast<long long>(first), count, static_cast<long long>(nf));
        const period::PowerQuery query(stream);
        query.check();
        query.check_powers(first, count);
        query.range(first, count, power);
        if (normalisation == TOLIMAN_PERIOD_POWER_STANDARD)
            return;
        const double half_chi_square = query.half_chi_square();
        for (size_t i = 0; i < count; i++)
            power[i] = normalised(power[i], normalisation, half_chi_square);
    });
}

toliman_status toliman_period_query_model(const toliman_period *period, int64_t k, toliman_period_model *out) noexcept {
    return query(period, "period", out, [&](auto &self, auto &result) {
        const period::Stream &stream = self.stream;
        const period::PowerQuery query(stream);
        check_model(query, stream, k);
        const period::Model model = query.model(k);
        query.check_power(k, model.power);
        TOLIMAN_COPY(result, model, rank, power, amplitude, phase, offset, amplitude_error, phase_error, offset_error);
        result.flags = model.inaccurate ? TOLIMAN_PERIOD_INACCURATE : 0;
        result.frequency = stream.grid().f0 + stream.grid().df * static_cast<double>(k);
    });
}

toliman_status toliman_period_query_peaks(const toliman_period *period, toliman_period_peak *peaks, size_t capacity,
                                          size_t *count) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        const StructArray<toliman_period_peak> results(peaks, "peaks");
        required(count, "count");
        if (capacity < 1 || capacity > period::kMaxPeaks)
            fail(Status::argument, "{capacity} = %zu: must be in [1, %zu]", capacity, period::kMaxPeaks);
        period::Peak found[period::kMaxPeaks];
        *count = period::find_peaks(stream, capacity, found);
        for (size_t i = 0; i < *count; i++)
            results.put(i, public_peak(stream, found[i]));
    });
}

toliman_status toliman_period_query_peak(const toliman_period *period, toliman_period_peak *out) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        required(out, "out");
        deliver(public_peak(stream, period::find_peak(stream)), out, "out");
    });
}

toliman_status toliman_period_query_fit(const toliman_period *period, const double *t, const double *y,
                                        const double *sigma, const double *rows, size_t n,
                                        toliman_period_peak *out) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        const period::Samples samples = {&required(t, "t"), &required(y, "y"), sigma, n, rows};
        required(out, "out");
        deliver(public_fit(stream, samples), out, "out");
    });
}

toliman_status toliman_period_save(const toliman_period *period, void *bytes, size_t capacity,
                                   size_t *needed) noexcept {
    return call(period, "period", [&](auto &self) {
        const period::Stream &stream = self.stream;
        if (capacity < stream.saved_size()) // known without saving
            check_bytes(stream.saved_size(), bytes, capacity, needed);
        deliver_bytes(stream.save(), bytes, capacity, needed);
    });
}

toliman_status toliman_period_load(const void *bytes, size_t size, const toliman_load_options *options,
                                   toliman_period **out) noexcept {
    return guard([&] {
        const MemoryScope scope(memory_of(options));
        required(bytes, "bytes");
        required(out, "out");
        *out = new toliman_period{{}, period::Stream::load(bytes, size)};
    });
}

toliman_status toliman_period_save_file(const toliman_period *period, const char *path) noexcept {
    return guard([&] {
        const std::vector<uint8_t> bytes = Use(period, "period")->stream.save();
        file::replace(&required(path, "path"), bytes.data(), bytes.size());
    });
}

toliman_status toliman_period_load_file(const char *path, const toliman_load_options *options,
                                        toliman_period **out) noexcept {
    return guard([&] {
        const MemoryScope scope(memory_of(options));
        required(out, "out");
        const std::vector<uint8_t> header = file::head(&required(path, "path"), period::Stream::kHeaderSize);
        size_t size = 0;
        in_file(path, [&] { size = period::Stream::saved_size(header.data(), header.size()); });
        const std::vector<uint8_t> bytes = file::read(path, size);
        in_file(path, [&] { *out = new toliman_period{{}, period::Stream::load(bytes.data(), bytes.size())}; });
    });
}

} // extern "C"
