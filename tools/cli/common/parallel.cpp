#include "common/parallel.hpp"

#include <atomic>
#include <exception>
#include <system_error>
#include <thread>

namespace cli {

void run_parallel(size_t count, const std::function<void(size_t)> &job, size_t most) {
    std::vector<std::exception_ptr> failures(count);
    std::atomic<size_t> next{1};
    const auto work = [&](size_t i) noexcept {
        for (; i < count; i = next++) {
            try {
                job(i);
            } catch (...) {
                failures[i] = std::current_exception();
                next = count;
            }
        }
    };
    std::vector<std::thread> threads;
    const size_t wanted = std::min<size_t>(count, most > 0 ? most : std::max(1u, std::thread::hardware_concurrency()));
    try {
        while (threads.size() + 1 < wanted)
            threads.emplace_back([&] { work(next++); });
    } catch (const std::system_error &) { // no more threads available: the others run all jobs
    }
    work(0);
    for (std::thread &thread : threads)
        thread.join();
    for (const std::exception_ptr &failure : failures)
        if (failure)
            std::rethrow_exception(failure);
}

} // namespace cli
