// Own worker threads with a static partition: job i always runs as job i, so results cannot depend on the count.
#pragma once
#include <cstddef>
#include <functional>

namespace toliman {

constexpr unsigned kMostWorkers = 1024;

// `requested`, or the number of processors when it is 0; at most kMostWorkers.
unsigned worker_count(unsigned requested) noexcept;

// Runs job(0) ... job(count - 1), worker w taking w, w + workers, ...; the caller is worker 0, and each
// for which the system has no thread. The first exception (lowest worker) is rethrown after all workers have stopped.
// after_own is called on the caller's thread after each of its own jobs with the fraction done there; it may throw to
// cancel, and the other workers then stop early.
void run_jobs(unsigned workers, size_t count, const std::function<void(size_t)> &job,
              const std::function<void(double)> &after_own = nullptr);

} // namespace toliman
