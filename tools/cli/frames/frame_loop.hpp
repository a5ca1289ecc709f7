// Simulates the frames of a scene in chunks, on all processors, for `run` and `experiment`.
#pragma once
#include <chrono>
#include <functional>
#include <vector>

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

// Variance of the frames divided by the variance that the Cramer-Rao bound assumes, summed over pixels; 0 without
// noise, below 1 for a scene without photon noise.
double noise_share(const Scene &scene, uint64_t seed);
constexpr double kLeastShare = 0.9; // smallest noise share for which an efficiency is defined

double mean(const std::vector<double> &values);
double squares(const std::vector<double> &values); // sum of the squared distances from the mean
double deviation(const std::vector<double> &values);

} // namespace cli
