// Pushes and retracts many samples, all or none.
#pragma once
#include "base/error.hpp"
#include "period/stream/stream.hpp"

namespace toliman::period {

// All samples are checked before the first is added. Given: n, check(), which throws Error for a bad number, and
// at(stream, i), a sample.
template <class Given> void check_all(const Stream &stream, const Given &given) {
    given.check();
    WeightingCheck weighting(stream);
    for (size_t i = 0; i < given.n; i++) {
        const Sample sample = given.at(stream, i);
        const int64_t index = given.n > 1 ? static_cast<int64_t>(i) : -1;
        stream.check(sample, index);
        weighting.check(sample, index);
    }
}

template <class Given> void push_all(Stream &stream, const Given &given) {
    check_all(stream, given);
    for (size_t i = 0; i < given.n; i++)
        stream.push(given.at(stream, i));
}

// Sums that no set of samples can have reveal a wrong retract: it is undone by pushing the samples again, which
// restores the exact sums bit by bit.
template <class Given> void retract_all(Stream &stream, const Given &given) {
    if (given.n > static_cast<uint64_t>(stream.totals().count))
        fail(Status::state, "cannot retract %zu samples: the periodogram has %lld", given.n,
             static_cast<long long>(stream.totals().count));
    check_all(stream, given);
    for (size_t i = 0; i < given.n; i++)
        stream.retract(given.at(stream, i));
    try {
        stream.check_consistent();
    } catch (...) {
        for (size_t i = 0; i < given.n; i++)
            stream.push(given.at(stream, i));
        throw;
    }
}

} // namespace toliman::period
