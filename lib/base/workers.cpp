// Method: worker w of W runs jobs w, w + W, w + 2 W, ...: a static partition. A job depends on its number only and
// writes only its own results, so that any number of workers gives the same bits.
// Why: the jobs of a call have similar costs, so that a queue would gain little. Threads are started per call and
// joined before it returns: the library keeps no thread between calls, which fork() and signal handlers of the host
// would meet. The calling thread works as well, and runs the jobs of threads that the system refuses to start.
#include "base/workers.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace toliman {

unsigned worker_count(unsigned requested) noexcept {
    return std::clamp(requested != 0 ? requested : std::thread::hardware_concurrency(), 1u, kMostWorkers);
}

void run_jobs(unsigned workers, size_t count, const std::function<void(size_t)> &job,
              const std::function<void(double)> &after_own) {
    const size_t used = std::max<size_t>(1, std::min<size_t>(workers, count));
    std::vector<std::exception_ptr> failure(used);
    std::atomic<bool> stop{false};
    const auto work = [&](size_t worker) noexcept {
        try {
            for (size_t i = worker; i < count && !stop.load(std::memory_order_relaxed); i += used) {
                job(i);
                if (worker == 0 && after_own)
                    after_own(static_cast<double>(i + 1) / static_cast<double>(count));
            }
        } catch (...) {
            failure[worker] = std::current_exception();
            stop.store(true, std::memory_order_relaxed);
        }
    };
    std::vector<std::thread> threads;
    threads.reserve(used - 1);
    try {
        while (threads.size() < used - 1)
            threads.emplace_back(work, threads.size() + 1);
    } catch (...) { // no more threads available: the calling thread runs the jobs of the missing workers
    }
    work(0);
    for (size_t worker = threads.size() + 1; worker < used; worker++)
        work(worker);
    for (std::thread &thread : threads)
        thread.join();
    for (const std::exception_ptr &exception : failure)
        if (exception)
            std::rethrow_exception(exception);
}

} // namespace toliman
