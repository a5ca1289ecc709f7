// FFTW's planner is not thread-safe, and the host program may use FFTW too: a mutex of ours would not exclude the host.
// fftw_make_planner_thread_safe() installs one lock for the process. Plans use FFTW_ESTIMATE: measured plans depend on
// timing, so that equal input could give different last bits from run to run.
#include "backend/fft.hpp"

#include <fftw3.h>
#include <mutex>
#include <new>

#include "base/buffer.hpp"

namespace toliman::fft {

namespace {
void make_planner_thread_safe() noexcept {
    static std::once_flag once;
    std::call_once(once, fftw_make_planner_thread_safe);
}
} // namespace

const char *version() noexcept {
    return fftw_version;
}

size_t fast_size(size_t n) noexcept {
    for (n += n % 2;; n += 2) {
        size_t rest = n;
        for (const size_t prime : {size_t{2}, size_t{3}, size_t{5}})
            while (rest % prime == 0)
                rest /= prime;
        if (rest == 1)
            return n;
    }
}

struct Square::Plan {
    Buffer<std::complex<double>> data;
    fftw_plan plan = nullptr;
};

Square::Square(size_t n) : plan_(std::make_unique<Plan>()) {
    make_planner_thread_safe();
    plan_->data.resize(n * n);
    auto *const memory = reinterpret_cast<fftw_complex *>(data());
    plan_->plan =
        fftw_plan_dft_2d(static_cast<int>(n), static_cast<int>(n), memory, memory, FFTW_FORWARD, FFTW_ESTIMATE);
    if (plan_->plan == nullptr)
        throw std::bad_alloc();
}

Square::~Square() {
    fftw_destroy_plan(plan_->plan);
}

std::complex<double> *Square::data() noexcept {
    return plan_->data.data();
}

void Square::transform() noexcept {
    fftw_execute(plan_->plan);
}

Real::Real(size_t n) {
    make_planner_thread_safe();
    Buffer<double> memory(n + 2); // an estimated plan reads only its alignment
    plan_ = fftw_plan_dft_r2c_1d(static_cast<int>(n), memory.data(), reinterpret_cast<fftw_complex *>(memory.data()),
                                 FFTW_ESTIMATE);
    if (plan_ == nullptr)
        throw std::bad_alloc();
}

Real::~Real() {
    fftw_destroy_plan(static_cast<fftw_plan>(plan_));
}

void Real::transform(double *x) const noexcept {
    fftw_execute_dft_r2c(static_cast<fftw_plan>(plan_), x, reinterpret_cast<fftw_complex *>(x));
}

} // namespace toliman::fft
