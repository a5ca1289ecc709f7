// Method: a walk over the indices of the exposures, whose steps take 0.1 us, so that a frame can be drawn alone.
//   jitter       an Ornstein-Uhlenbeck process per axis, x' = a x + sqrt(1 - a^2) rms n, a = exp(-2 pi corner/rate):
//                exact at the exposures, with the spectrum 1/(1 + (f/corner)^2). That within an exposure is jitter of
//                the scene
//   drops        two states with geometric lengths; runs begin with the probability drops/(run (1 - drops))
//   cosmic rays  Poisson number of hits, each in one pixel: a track of an isotropic flux through a layer is 1/cosine
//                times its thickness long, so that the charge has the distribution P(> q) = (q0/q)^2
// Uniform numbers are hashes (the finalizer of SplitMix64: Steele, Lea, Flood 2014) of seed, use and index.
#include "frames/stream.hpp"

#include <algorithm>
#include <cmath>

namespace cli {

namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kPause = 1;                               // s without frames after a restart or before a new session
constexpr double kLeastCharge = 800, kLargestCharge = 1e6; // electrons, 10 um of silicon at 80 per um
constexpr int64_t kStep = 1000;                            // ns of the camera's clock
constexpr uint64_t kDrawsPerFrame = 1024;                  // of cosmic rays

uint64_t hash(uint64_t z) noexcept {
    z += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

} // namespace

double StreamNoise::uniform(Use use, uint64_t counter) const noexcept {
    const uint64_t bits = hash(hash(hash(seed_) ^ static_cast<uint64_t>(use)) ^ counter);
    return (static_cast<double>(bits >> 12) + 0.5) * 0x1p-52;
}

Stream::Stream(const StreamOptions &options, uint64_t seed, int64_t time_zero_ns)
    : options_(options), noise_(seed), time_zero_ns_(time_zero_ns),
      count_(std::llround(options.duration_s * options.rate_hz)), pause_(std::llround(kPause * options.rate_hz)),
      restart_(std::llround(options.restart_s * options.rate_hz)),
      session_(std::llround(options.session_s * options.rate_hz)),
      memory_(std::exp(-kTwoPi * options.corner_hz / options.rate_hz)), push_(std::sqrt(1 - memory_ * memory_)) {}

void Stream::move(Exposure &exposure) {
    const auto k = static_cast<uint64_t>(exposure.index);
    const double radius = std::sqrt(-2 * std::log(noise_.uniform(StreamNoise::Use::jitter, 2 * k))),
                 angle = kTwoPi * noise_.uniform(StreamNoise::Use::jitter, 2 * k + 1);
    const double normal[] = {radius * std::cos(angle), radius * std::sin(angle)};
    for (size_t i = 0; i < 2; i++)
        jitter_[i] = k == 0 ? normal[i] : memory_ * jitter_[i] + push_ * normal[i];
    const double phase = kTwoPi * exposure.time_s / options_.drift_s;
    exposure.x_px = options_.jitter_px * jitter_[0] + options_.drift_px * std::cos(phase);
    exposure.y_px = options_.jitter_px * jitter_[1] + options_.drift_px * std::sin(phase);
}

void Stream::drop(int64_t index) {
    const double begins = options_.drops / (options_.drop_run * (1 - options_.drops)), ends = 1 / options_.drop_run;
    const double uniform = noise_.uniform(StreamNoise::Use::drops, static_cast<uint64_t>(index));
    is_dropping_ = is_dropping_ ? uniform >= ends : uniform < begins;
}

bool Stream::next(Exposure &exposure) {
    const int64_t k = next_++;
    exposure = {};
    exposure.index = k;
    exposure.time_s = static_cast<double>(k) / options_.rate_hz;
    exposure.host_s = static_cast<double>(k + 1) / options_.rate_hz;
    move(exposure);
    drop(k);
    exposure.session = session_ > 0 ? k / session_ : 0;
    int64_t since = k - exposure.session * session_; // frames of the counter, from its start
    exposure.restarts = restart_ > 0 ? since / restart_ : 0;
    since -= exposure.restarts * restart_;
    if (exposure.session > 0 || exposure.restarts > 0)
        since -= pause_;
    if (since < 0)
        return false;
    if (since == 0) {
        last_id_ = -1;
        if (exposure.restarts > 0) {
            power_on_ = k;
            power_ons_++; // a clock starts so many us after 0: no time of FITS files occurs twice
        }
    }
    exposure.frame_id = since;
    exposure.stamp_ns = (power_ons_ == 0 ? time_zero_ns_ : power_ons_ * kStep) +
                        std::llround(static_cast<double>(k - power_on_) * 1e6 / options_.rate_hz) * kStep;
    exposure.is_dropped = is_dropping_;
    if (!is_dropping_) {
        exposure.dropped = since - last_id_ - 1;
        last_id_ = since;
    }
    return true;
}

std::vector<Hit> Stream::hits(int64_t index, size_t pixels) const {
    uint64_t draw = static_cast<uint64_t>(index) * kDrawsPerFrame;
    const auto uniform = [&] { return noise_.uniform(StreamNoise::Use::hits, draw++); };
    std::vector<Hit> hits;
    double chance = std::exp(-options_.hits), sum = chance;
    const double number = uniform();
    for (size_t n = 1; number > sum && n < kDrawsPerFrame / 4; n++, sum += chance) {
        chance *= options_.hits / static_cast<double>(n);
        const auto pixel = static_cast<size_t>(uniform() * static_cast<double>(pixels));
        const double charge = std::min(kLargestCharge, kLeastCharge / std::sqrt(uniform()));
        if (std::none_of(hits.begin(), hits.end(), [&](const Hit &other) { return other.pixel == pixel; }))
            hits.push_back({pixel, charge});
    }
    return hits;
}

} // namespace cli
