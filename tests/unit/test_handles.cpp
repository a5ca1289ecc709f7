// The owning handles of toliman.hpp: one of each made, used and ended. No CMocka: it would jump over destructors.
#include <cstdio>
#include <string>

#include <toliman/toliman.hpp>

namespace {

constexpr char kScene[] = R"({"schema": "toliman-scene/1", "telescope": {"aperture_m": 0.125, "pupil_samples": 128},
    "band": {"wavelength_nm": 550}, "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}}},
    "cadence": {"frames": 10, "peak_photons": 1e6}, "detector": {"shape": [256, 256], "pixel_scale_arcsec": 0.1}})";

int make_one_of_each() {
    using namespace toliman;
    const auto sim = make<simulator>(toliman_sim_create_json, kScene, sizeof kScene - 1, nullptr, nullptr);
    const auto cae = make<autoencoder>(toliman_cae_create, sim.get(), 1u, nullptr);
    const auto linear = make<linear_estimator>(toliman_linear_create, sim.get());
    const auto components = make<component_set>(toliman_linear_create_components, sim.get(), nullptr);
    const auto period = make<periodogram>(toliman_period_create, 0.0, 0.1, 3, nullptr);
    const auto track = make<frame_index>(toliman_track_create, 10);
    int32_t verdict = -1;
    check(toliman_track_push(track.get(), "session", 1, "roi", "bytes", 5, &verdict));
    return cae && linear && components && period && verdict == TOLIMAN_TRACK_NEW &&
                   toliman_track_count(track.get()) == 1
               ? 0
               : 1;
}

int a_failure_is_an_exception() {
    try {
        toliman::make<toliman::frame_index>(toliman_track_create, 0);
    } catch (const toliman::error &error) {
        return error.status() == TOLIMAN_E_ARGUMENT && std::string(error.what()).find("capacity = 0") == 0 ? 0 : 1;
    }
    return 1;
}

} // namespace

int main() {
    const int failed = make_one_of_each() + a_failure_is_an_exception();
    std::printf("%d failed\n", failed);
    return failed;
}
