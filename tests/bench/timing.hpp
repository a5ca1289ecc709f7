// Times of a function that is called again and again.
#ifndef TOLIMAN_TESTS_TIMING_HPP
#define TOLIMAN_TESTS_TIMING_HPP

#include <functional>
#include <vector>

#include "timing.h"

// Of one call; each of the times is that of so many calls.
inline timing measure(int repeats, int calls, const std::function<void()> &work) {
    std::vector<double> times;
    for (int r = 0; r < repeats; r++) {
        const double start = processor_s();
        for (int i = 0; i < calls; i++)
            work();
        times.push_back((processor_s() - start) / calls);
    }
    return timing_of(times.data(), times.size());
}

#endif
