// Simulates the frames of a scene in chunks, on all processors, for `run`.
#pragma once
#include <chrono>

#include "common/common.hpp"
#include "scenes/scene.hpp"

namespace cli {

// Adds the seconds between its construction and destruction to a sum.
class Stopwatch {
  public:
    explicit Stopwatch(double &sum) : sum_(sum), start_(std::chrono::steady_clock::now()) {}
    ~Stopwatch() { sum_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    Stopwatch(const Stopwatch &) = delete;
    Stopwatch &operator=(const Stopwatch &) = delete;

  private:
    double &sum_;
    std::chrono::steady_clock::time_point start_;
};

// Simulates frames first ... first + total - 1 of (scene, seed), with the given displacements (`total` of them) or, if
// null, with those of the cadence. `work` receives `count` images, beginning with frame first + at, and may change
// them. A signal stops the loop between two chunks. The time of the simulation is added to *seconds.
using FrameWork = std::function<void(size_t at, size_t count, double *images)>;
void for_frames(const Scene &scene, uint64_t seed, int64_t first, size_t total, const double *displacements,
                const FrameWork &work, double *seconds = nullptr);

double mean(const std::vector<double> &values);
double deviation(const std::vector<double> &values);

} // namespace cli
