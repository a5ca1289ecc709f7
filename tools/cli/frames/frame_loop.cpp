#include "frames/frame_loop.hpp"

#include <numeric>

namespace cli {

void for_frames(const Scene &scene, uint64_t seed, int64_t first, size_t total, const double *displacements,
                const FrameWork &work, double *seconds) {
    constexpr size_t kFramesAtOnce = 48;
    double ignored = 0;
    std::vector<double> images(std::min(total, kFramesAtOnce) * scene.pixels());
    for (size_t done = 0; done < total;) {
        const size_t count = std::min(kFramesAtOnce, total - done);
        {
            const Stopwatch watch(seconds != nullptr ? *seconds : ignored);
            toliman::check(toliman_sim_frame(scene.sim.get(), displacements != nullptr ? displacements + done : nullptr,
                                             seed, first + static_cast<int64_t>(done), count, images.data()));
        }
        work(done, count, images.data());
        done += count;
        stop_if_asked();
    }
}

double mean(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation(const std::vector<double> &values) {
    const auto add_square = [centre = mean(values)](double sum, double value) {
        return sum + (value - centre) * (value - centre);
    };
    return std::sqrt(std::accumulate(values.begin(), values.end(), 0.0, add_square) /
                     static_cast<double>(values.size() - 1));
}

} // namespace cli
