// Nanoseconds per pixel of the Poisson kernel with each instruction set of this processor, one JSON object per line;
// median of nine, processor time. sim.py runs this program and numpy.
#include <cmath>
#include <cstdio>
#include <vector>

#include "kernels/poisson.hpp"
#include "timing.hpp"

using namespace toliman::kernels;

namespace {

constexpr size_t kPixels = 1 << 18;

timing frame_time(const PoissonKernels &kernels, const std::vector<double> &means) {
    std::vector<double> counts(means.size());
    uint64_t frame = 0;
    return measure(9, 1, [&] {
        kernels.poisson(means.data(), means.size(), 0, {1, frame++, kStreamPhotons}, counts.data());
    });
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
            const timing time = frame_time(*sets[isa].kernels, means);
            std::printf(
                "{\"part\": \"poisson\", \"isa\": \"%s\", \"decades\": %g, \"ns\": %.4g, \"spread_ns\": %.2g}\n",
                sets[isa].name, decades, time.median / kPixels * 1e9, time.spread / kPixels * 1e9);
        }
    }
    return 0;
}
