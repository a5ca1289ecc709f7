// Estimates values of many frames on worker threads; shared by all estimators.
#pragma once
#include <algorithm>
#include <vector>

#include "base/buffer.hpp"
#include "base/error.hpp"
#include "base/workers.hpp"
#include "frame/bad_pixels.hpp"
#include "frame/pixel.hpp"

namespace toliman {

// Given     frames; make_work() returns the working memory of a worker; estimate(group, first, size, work) of the
//           frames first ... first + size - 1, at most `together` at once
// Notes     one job and one working memory per worker. A group that fails is repeated frame by frame, so that the error
//           names the frame.
template <class MakeWork, class Estimate>
void for_groups(const PixelFrames &frames, size_t count, size_t together, unsigned workers, MakeWork make_work,
                Estimate estimate) {
    const size_t threads = worker_count(workers);
    together = std::min(together, (count + threads - 1) / threads); // all of them at work; the bits are the same
    const size_t jobs = std::min(threads, (count + together - 1) / together);
    run_jobs(static_cast<unsigned>(jobs), jobs, [&](size_t job) {
        auto work = make_work();
        std::vector<Buffer<double>> converted(together);
        std::vector<ImageView<const double>> group(together);
        for (size_t first = job * together; first < count; first += jobs * together) {
            const size_t size = std::min(together, count - first);
            for (size_t i = 0; i < size; i++)
                group[i] = frames.frame(first + i, converted[i]);
            try {
                estimate(group.data(), first, size, work);
            } catch (const Error &) {
                for (size_t i = 0; i < size; i++)
                    in_frame(first + i, [&] { estimate(&group[i], first + i, 1, work); });
                throw;
            }
        }
    });
}

// Given     frames; make_work() as above; estimate(group, first, size, work, values, goodness) of a group of at most
//           `together` frames, with goodness NULL if not requested
// Returned  values [count] and, unless NULL, goodness [count]; bit-identical for any number of workers
// Notes     nothing is written if a frame fails
template <class MakeWork, class Estimate>
void estimate_many(const PixelFrames &frames, size_t count, size_t together, unsigned workers, double *values,
                   FrameGoodness *goodness, MakeWork make_work, Estimate estimate) {
    Buffer<double> results(count);
    Buffer<FrameGoodness> fits(goodness != nullptr ? count : 0);
    for_groups(frames, count, together, workers, make_work,
               [&](const ImageView<const double> *group, size_t first, size_t size, auto &work) {
                   estimate(group, first, size, work, &results[first], goodness != nullptr ? &fits[first] : nullptr);
               });
    std::copy(results.begin(), results.end(), values);
    std::copy(fits.begin(), fits.end(), goodness);
}

} // namespace toliman
