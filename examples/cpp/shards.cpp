// Shards in C++: each thread simulates and estimates its share of the frames and fills its own periodogram. The merged
// periodogram is bit-identical to that of a single thread, because its sums are exact.
//
//     shards SCENE THREADS
#include <cstdio>
#include <cstdlib>
#include <future>
#include <vector>

#include <toliman/toliman.hpp>

namespace {

// Owns the objects that all threads share: const functions may run on one object from several threads.
class Mission {
  public:
    explicit Mission(const char *scene)
        : sim_(toliman::make<toliman::simulator>(toliman_sim_create_file, scene, nullptr)),
          estimator_(toliman::make<toliman::linear_estimator>(toliman_linear_create, sim_.get(), nullptr)) {
        toliman::check(toliman_sim_get_info(sim_.get(), &info_));
    }

    // Periodogram of frames first, first + step, ...; frequencies up to one cycle per two frames.
    toliman::periodogram sums(int64_t first, int64_t step) const {
        const auto frames = static_cast<double>(info_.frames);
        auto period = toliman::make<toliman::periodogram>(toliman_period_create, 1.5 / frames, 0.1 / frames,
                                                          5 * info_.frames - 14, nullptr);
        std::vector<double> pixels(static_cast<size_t>(info_.rows * info_.cols));
        auto image = toliman::sized<toliman_image>();
        image.pixels = pixels.data();
        for (int64_t k = first; k < info_.frames; k += step) {
            double time, value;
            toliman::check(toliman_sim_get_series(sim_.get(), k, 1, &time, nullptr));
            toliman::check(toliman_sim_frame(sim_.get(), nullptr, info_.seed, k, 1, pixels.data()));
            toliman::check(toliman_linear_encode(estimator_.get(), &image, 1, &value, nullptr));
            toliman::check(toliman_period_push(period.get(), time, value, 1));
        }
        return period;
    }

  private:
    toliman::simulator sim_;
    toliman::linear_estimator estimator_;
    toliman_sim_info info_ = toliman::sized<toliman_sim_info>();
};

void find_period(const Mission &mission, int threads) {
    std::vector<std::future<toliman::periodogram>> shards;
    for (int i = 1; i < threads; i++)
        shards.push_back(std::async(std::launch::async, [&mission, i, threads] { return mission.sums(i, threads); }));
    const toliman::periodogram period = mission.sums(0, threads);
    for (auto &shard : shards) // get() rethrows an exception of the thread
        toliman::check(toliman_period_merge(period.get(), shard.get().get()));
    auto peak = toliman::sized<toliman_period_peak>();
    toliman::check(toliman_period_query_peak(period.get(), &peak));
    std::printf("period %.2f days, log10 FAP %.1f, power %.17g\n", peak.period, peak.log10_fap, peak.power);
}

} // namespace

int main(int argc, char **argv) {
    const int threads = argc == 3 ? std::atoi(argv[2]) : 0;
    if (threads < 1) {
        std::fprintf(stderr, "usage: shards SCENE THREADS\n");
        return EXIT_FAILURE;
    }
    try {
        find_period(Mission(argv[1]), threads);
    } catch (const toliman::error &error) {
        std::fprintf(stderr, "%s: %s\n", toliman_constant_name(error.status()), error.what());
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
