// Pushes and retracts the samples of a caller, all or none.
#pragma once
#include <optional>

#include <toliman/period.h>

#include "api/guard.hpp"
#include "api/handles.hpp"
#include "api/struct_array.hpp"
#include "period/stream/many.hpp"

namespace toliman::api {

// The caller's samples as arrays; sigma NULL means unweighted.
struct Arrays {
    const double *t, *y, *sigma;
    size_t n;

    void check() const {
        required_array(t, n, sizeof *t, "t");
        required_array(y, n, sizeof *y, "y");
    }
    period::Sample at(const period::Stream &stream, size_t i) const noexcept {
        const double known = sigma != nullptr ? sigma[i] : stream.grid().sigma_floor;
        period::Sample sample = stream.sample(t[i], 0, y[i], known);
        sample.unweighted = sigma == nullptr;
        return sample;
    }
};

// The caller's samples as structs, with the values of their columns; sigma 0 means unweighted.
struct Structs {
    std::optional<StructArray<const toliman_period_sample>> samples;
    size_t n;
    const double *columns; // [n][columns of the basis]; may be NULL

    Structs(const toliman_period_sample *first, size_t count, const double *values) : n(count), columns(values) {
        required_array(first, count, sizeof *first, "samples");
        if (count > 0)
            samples.emplace(first, "samples");
    }
    void check() const {
        for (size_t i = 0; i < n; i++) {
            const toliman_period_sample given = samples->get(i);
            if ((given.flags & ~TOLIMAN_PERIOD_TIME_NS) != 0)
                fail(Status::argument, "{samples[%zu].flags} = 0x%x: unknown bits", i, given.flags);
            if (given.flags == 0 && given.t_ns != 0)
                fail(Status::argument, "{samples[%zu].t_ns} = %lld: must be 0 without TOLIMAN_PERIOD_TIME_NS", i,
                     static_cast<long long>(given.t_ns));
            if (given.flags != 0 && (given.t != 0 || given.t_low != 0))
                fail(Status::argument, "{samples[%zu].t} = %g, t_low = %g: must be 0 with TOLIMAN_PERIOD_TIME_NS", i,
                     given.t, given.t_low);
        }
    }
    period::Sample at(const period::Stream &stream, size_t i) const noexcept {
        const toliman_period_sample given = samples->get(i);
        const double sigma = given.sigma != 0 ? given.sigma : stream.grid().sigma_floor;
        period::Sample sample = given.flags != 0 ? stream.sample_ns(given.t_ns, given.y, sigma)
                                                 : stream.sample(given.t, given.t_low, given.y, sigma);
        sample.unweighted = given.sigma == 0;
        if (columns != nullptr)
            sample.columns = columns + i * static_cast<size_t>(stream.grid().basis.columns);
        return sample;
    }
};

template <class Given> void push_all(toliman_period *period, const Given &given) {
    period::push_all(Use(period, "period")->stream, given);
}

inline void retract_all(toliman_period *period, const Structs &given) {
    period::retract_all(Use(period, "period")->stream, given);
}

} // namespace toliman::api
