// A shortage of memory while a frame is fitted is not the frame's: the push fails, no frame is rejected, and the rest
// can be pushed again. operator new fails from the n-th allocation of a push on, for every n.
#include <atomic>
#include <climits>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

#include <toliman/toliman.hpp>

namespace {

std::atomic<int> left{INT_MAX};

constexpr size_t kSide = 64, kFrames = 12;
constexpr int kRounds = 10; // threads meet in another order in each
constexpr const char *kScene = R"({"schema": "toliman-scene/1", "telescope": {"aperture_m": 0.125, "pupil_samples": 48},
 "band": {"wavelength_nm": 550}, "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}},
 "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}}},
 "binary": {"separation_arcsec": 2, "position_angle_deg": 30}, "cadence": {"frames": 12, "peak_photons": 1e5},
 "detector": {"shape": [64, 64], "pixel_scale_arcsec": 0.2}})";

void *allocated(std::size_t size, std::size_t alignment) {
    if (left.fetch_sub(1) <= 0)
        throw std::bad_alloc();
    void *const memory = alignment > alignof(std::max_align_t)
                             ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                             : std::malloc(size);
    if (memory == nullptr)
        throw std::bad_alloc();
    return memory;
}

void must(bool holds, const char *what, int allowed) {
    if (holds)
        return;
    std::fprintf(stderr, "after %d allocations: %s: %s\n", allowed, what, toliman_last_error());
    std::exit(1);
}

} // namespace

void *operator new(std::size_t size) {
    return allocated(size, 0);
}
void *operator new(std::size_t size, std::align_val_t alignment) {
    return allocated(size, static_cast<std::size_t>(alignment));
}
void operator delete(void *memory) noexcept {
    std::free(memory);
}
void operator delete(void *memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete(void *memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void *memory, std::size_t, std::align_val_t) noexcept {
    std::free(memory);
}

// Pushes all frames to a new fit and tracker after `allowed` allocations. Returns whether they sufficed.
bool push(const toliman_sim *sim, const std::vector<double> &images, int allowed, int &failed) {
    toliman_fit *fit = nullptr;
    toliman_track *track = nullptr;
    must(toliman_fit_create(&sim, nullptr, 1, nullptr, &fit) == TOLIMAN_OK, "the fit", allowed);
    auto options = toliman::sized<toliman_track_options>();
    options = toliman::sized<toliman_track_options>();
    options.flags = TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
    options.estimator.fit = fit;
    options.threads = 2;
    options.grid.f0 = options.grid.df = 0.001;
    options.grid.nf = 20;
    must(toliman_track_create(&options, &track) == TOLIMAN_OK, "the tracker", allowed);
    std::vector<toliman_frame> frames(kFrames, toliman::sized<toliman_frame>());
    std::vector<toliman_track_outcome> outcomes(kFrames, toliman::sized<toliman_track_outcome>());
    for (size_t i = 0; i < kFrames; i++) {
        frames[i].pixel = TOLIMAN_PIXEL_F64;
        frames[i].session = frames[i].roi = "s";
        frames[i].frame_id = static_cast<int64_t>(i);
        frames[i].camera_ns = frames[i].frame_id * 86400000000000;
        frames[i].pixels = &images[i * kSide * kSide];
        frames[i].rows = frames[i].cols = kSide;
    }
    size_t done = 0;
    left = allowed;
    const toliman_status status = toliman_track_push(track, frames.data(), kFrames, outcomes.data(), &done);
    const bool enough = left.exchange(INT_MAX) >= 0;
    must(status == TOLIMAN_E_MEMORY || (status == TOLIMAN_OK && done == kFrames), "the push", allowed);
    failed += status == TOLIMAN_E_MEMORY ? 1 : 0;
    must(done == kFrames ||
             toliman_track_push(track, &frames[done], kFrames - done, outcomes.data(), &done) == TOLIMAN_OK,
         "the second push", allowed);
    auto info = toliman::sized<toliman_track_info>();
    must(toliman_track_get_info(track, &info) == TOLIMAN_OK, "the counts", allowed);
    must(info.rejected == 0 && info.accepted == kFrames, "a frame is rejected", allowed);
    toliman_track_destroy(track);
    toliman_fit_destroy(fit);
    return enough;
}

// promise: memory-failures-are-survived
int main() {
    toliman_sim *sim = nullptr;
    must(toliman_sim_create_json(kScene, std::strlen(kScene), nullptr, nullptr, &sim) == TOLIMAN_OK, "the scene", 0);
    std::vector<double> images(kFrames * kSide * kSide);
    must(toliman_sim_frame(sim, nullptr, 3, 0, kFrames, images.data()) == TOLIMAN_OK, "its frames", 0);
    int failed = 0;
    for (int round = 0; round < kRounds; round++)
        for (int allowed = 0; !push(sim, images, allowed, failed); allowed++)
            ;
    toliman_sim_destroy(sim);
    must(failed > 0, "no push was short of memory", 0);
    std::printf("%d pushes were short of memory: no frame rejected\n", failed);
    return 0;
}
