// Timing of a function that is called repeatedly.
#ifndef TOLIMAN_TESTS_TIMING_HPP
#define TOLIMAN_TESTS_TIMING_HPP

#include <cmath>
#include <functional>
#include <vector>

#include "timing.h"

// Time per call; each measurement is the mean over `calls` calls.
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

// The shortest time per call of many short samples: what the hardware allows, whatever else runs on the machine.
inline double shortest(int samples, int calls, const std::function<void()> &work) {
    double least = HUGE_VAL;
    for (int i = 0; i < samples; i++)
        least = std::fmin(least, measure(1, calls, work).median);
    return least;
}

#endif
