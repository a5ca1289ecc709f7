// Saved sums of short frames: what loads has possible numbers, saves to the same bytes, and ends as a frame.
#include <cmath>
// promises: parsers-are-safe, loading-restores-what-was-saved

#include <toliman/toliman.hpp>

#include "fuzz.hpp"

using namespace fuzz;

namespace {

constexpr size_t kSide = 16;
constexpr char kScene[] = R"({"schema": "toliman-scene/1", "name": "small",
 "telescope": {"aperture_m": 0.125, "pupil_samples": 32, "mask": {"kind": "clear"}},
 "band": {"min_nm": 550, "max_nm": 560, "step_nm": 10},
 "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 3e6},
  "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 1e6}},
 "binary": {"separation_arcsec": 4, "position_angle_deg": 30},
 "signal": {"kind": "none"}, "cadence": {"frames": 10, "interval_days": 1, "exposure_s": 0.01},
 "detector": {"shape": [16, 16], "pixel_scale_arcsec": 0.7, "bias_dn": 100, "gain_e_per_dn": 1},
 "noise": {"photon": true, "read_e": 2.5, "seed": 7}})";

toliman::frame_adder make_coadd() {
    const auto sim =
        toliman::make<toliman::simulator>(toliman_sim_create_json, kScene, sizeof kScene - 1, nullptr, nullptr);
    auto fit_options = toliman::sized<toliman_fit_options>();
    fit_options.capture_px = 2;
    fit_options.threads = 1;
    const toliman_sim *const sims[] = {sim.get()};
    const auto fit = toliman::make<toliman::frame_fit>(toliman_fit_create, sims, nullptr, size_t{1}, &fit_options);
    auto options = toliman::sized<toliman_coadd_options>();
    options.range_px = 1;
    options.threads = 1;
    options.chi_square_max = 1e6;
    return toliman::make<toliman::frame_adder>(toliman_coadd_create, fit.get(), nullptr, &options);
}

// One object for all inputs: a sum that loads replaces the one before, and one that does not leaves it.
toliman_coadd *sums() {
    static const toliman::frame_adder made = make_coadd();
    return made.get();
}

Bytes saved() {
    size_t size = 0;
    require(toliman_coadd_save(sums(), nullptr, 0, &size) == TOLIMAN_E_CAPACITY, "no size of the sum");
    Bytes bytes(size);
    require(toliman_coadd_save(sums(), bytes.data(), size, &size) == TOLIMAN_OK, "the sum cannot be saved");
    return bytes;
}

void add(int64_t camera_ns, const char *session) {
    uint16_t counts[kSide * kSide];
    for (size_t p = 0; p < kSide * kSide; p++)
        counts[p] = static_cast<uint16_t>(100 + 20000 / (1 + (p % kSide - 8) * (p % kSide - 8) + p / kSide));
    auto frame = toliman::sized<toliman_frame>();
    auto outcome = toliman::sized<toliman_coadd_outcome>();
    frame.pixel = TOLIMAN_PIXEL_U16;
    frame.session = session;
    frame.roi = "r";
    frame.pixels = counts;
    frame.rows = frame.cols = kSide;
    frame.camera_ns = camera_ns;
    frame.exposure_s = 0.01;
    require(toliman_coadd_add(sums(), &frame, &outcome) == TOLIMAN_OK, toliman_last_error());
}

void check_sum() {
    auto frame = toliman::sized<toliman_frame>();
    auto sum = toliman::sized<toliman_coadd_sum>();
    if (toliman_coadd_take(sums(), &frame, &sum) != TOLIMAN_OK)
        return;
    require(sum.frames > 0 && frame.interval_count > 0 && frame.interval_count <= 64, "impossible counts of a sum");
    require(frame.exposure_s > 0 && std::isfinite(frame.exposure_s), "an impossible exposure");
}

} // namespace

std::vector<Bytes> fuzz::seeds() {
    std::vector<Bytes> seeds = {saved()};
    for (int i = 0; i < 3; i++) {
        add(i * 10000000, "s");
        seeds.push_back(saved());
    }
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const Bytes before = saved();
    const toliman_status status = toliman_coadd_load(sums(), data, size);
    require(status == TOLIMAN_OK || status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_MISMATCH, toliman_last_error());
    require(saved() == (status == TOLIMAN_OK ? Bytes(data, data + size) : before), "other bytes than were loaded");
    if (status != TOLIMAN_OK)
        return 0;
    fuzz::accepted++;
    auto info = toliman::sized<toliman_coadd_info>();
    require(toliman_coadd_get_info(sums(), &info) == TOLIMAN_OK && info.frames >= 0 && info.rejected >= 0,
            "impossible counts");
    add(20000000, "s");
    check_sum();
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed) {
    Bytes bytes(data, data + size);
    mutate(bytes, most);
    const size_t whole = saved().size();
    if (seed % 8 != 0 && whole <= most)
        bytes.resize(whole);
    seal(bytes);
    return give(bytes, data, most);
}
