// Worker threads with a static partition of numbered jobs. A job depends on its number only, so that results do not
// depend on the number of workers.
#pragma once
#include <cstddef>
#include <functional>

namespace toliman {

constexpr unsigned kMostWorkers = 1024;

// Returns `requested`, or the number of processors if it is 0; at most kMostWorkers.
unsigned worker_count(unsigned requested) noexcept;

// Runs job(0) ... job(count - 1); worker w runs jobs w, w + workers, ... The calling thread is worker 0, and replaces
// each worker for which the system has no thread. After an exception the others stop early; once all have stopped, the
// exception of the lowest worker is rethrown. after_own is called on the calling thread after each job of worker 0 with
// the fraction of its jobs done; it may throw to cancel.
void run_jobs(unsigned workers, size_t count, const std::function<void(size_t)> &job,
              const std::function<void(double)> &after_own = nullptr);

} // namespace toliman
