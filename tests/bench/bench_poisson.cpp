// Nanoseconds a pixel of the Poisson kernel in each instruction set of this processor, one JSON object a line;
// processor time, median of nine. bench_sim.py runs it beside numpy.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>

#include "kernels/poisson.hpp"

using namespace toliman::kernels;

namespace {

constexpr size_t kPixels = 1 << 18;

double processor_s() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double ns_a_pixel(const PoissonKernels &kernels, const std::vector<double> &means) {
    std::vector<double> counts(means.size()), times;
    for (uint64_t frame = 0; frame < 9; frame++) {
        const double start = processor_s();
        kernels.poisson(means.data(), means.size(), 0, {1, frame, kStreamPhotons}, counts.data());
        times.push_back((processor_s() - start) / static_cast<double>(means.size()) * 1e9);
    }
    std::sort(times.begin(), times.end());
    return times[4];
}

} // namespace

int main() {
    const struct {
        const char *name;
        const PoissonKernels *kernels;
    } sets[] = {
        {"baseline", &poisson_baseline},
#if defined(__x86_64__)
        {"avx2", &poisson_avx2},
        {"avx512", &poisson_avx512}
#endif
    };
    for (size_t isa = 0; isa <= static_cast<size_t>(host_isa()); isa++) {
        for (const double decades : {5.0, 0.0}) { // means 1e4 to 1e9, and 1e4
            std::vector<double> means(kPixels);
            for (size_t i = 0; i < kPixels; i++)
                means[i] = 1e4 * std::pow(10.0, decades * static_cast<double>(i * 7919 % kPixels) / kPixels);
            std::printf("{\"part\": \"poisson\", \"isa\": \"%s\", \"decades\": %g, \"ns\": %.4g}\n", sets[isa].name,
                        decades, ns_a_pixel(*sets[isa].kernels, means));
        }
    }
    return 0;
}
