// Bounded resources: an input of up to 1 MiB needs at most 8 MiB of the heap plus twice the size of the object made
// from it, and 50 ms plus 5 ms per MiB of that object, regardless of its content.
#pragma once
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "heap_meter.hpp"

namespace bounds {

constexpr size_t kMiB = 1 << 20;

// Without optimisation, and on an emulated processor, which tests/elsewhere states, the limit is 20 times as long.
inline double most_seconds() {
#ifdef __OPTIMIZE__
    return std::getenv("TOLIMAN_EMULATED") != nullptr ? 1 : 0.05;
#else
    return 1;
#endif
}

constexpr int kMostAgain = 10;

inline int failures = 0;

// model: size in bytes of the object made from the input; 0 if the input is refused.
template <class Work> void within(const char *what, size_t model, Work work) {
    meter::Cost cost = meter::of(work);
    const double longest = most_seconds() * (1 + static_cast<double>(model) / (10 * kMiB));
    for (int again = 0; again < kMostAgain && cost.seconds >= longest; again++) {
        std::this_thread::sleep_for(std::chrono::milliseconds(200)); // the processor may be slower for a moment
        cost = meter::of(work);
    }
    const size_t most = 2 * model + 8 * kMiB;
    const bool good = cost.bytes < most && cost.seconds < longest;
    std::printf("%-44s %9zu of %9zu bytes %7.2f ms%s\n", what, cost.bytes, most, 1e3 * cost.seconds,
                good ? "" : ": TOO MUCH");
    failures += !good;
}

inline void expect(bool holds, const char *what) {
    if (holds)
        return;
    std::printf("%s\n", what);
    failures++;
}

} // namespace bounds
