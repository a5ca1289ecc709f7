// Estimates values of many frames on worker threads; shared by all estimators.
#pragma once
#include <algorithm>

#include "base/buffer.hpp"
#include "base/error.hpp"
#include "base/pixel.hpp"
#include "base/workers.hpp"

namespace toliman {

// Given     frames; estimate(frame, work, chi_square) of one frame, with chi_square NULL if not requested
// Returned  values [count] and, unless NULL, chi_square [count]; bit-identical for any number of workers
// Notes     one job and one Workspace per worker; nothing is written if a frame fails.
template <class Workspace, class Estimate>
void estimate_many(const PixelFrames &frames, size_t count, unsigned workers, double *values, double *chi_square,
                   Estimate estimate) {
    const size_t jobs = std::min<size_t>(worker_count(workers), count);
    Buffer<double> results(count), squares(chi_square != nullptr ? count : 0);
    run_jobs(static_cast<unsigned>(jobs), jobs, [&](size_t job) {
        Workspace work;
        Buffer<double> converted;
        for (size_t i = job; i < count; i += jobs)
            in_frame(i, [&] {
                results[i] = estimate(frames.frame(i, converted), work, chi_square != nullptr ? &squares[i] : nullptr);
            });
    });
    std::copy(results.begin(), results.end(), values);
    std::copy(squares.begin(), squares.end(), chi_square);
}

} // namespace toliman
