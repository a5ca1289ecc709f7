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
    const auto linear = make<linear_estimator>(toliman_linear_create, sim.get(), nullptr);
    const auto components = make<component_set>(toliman_linear_create_components, sim.get(), nullptr);
    const auto period = make<periodogram>(toliman_period_create, 0.0, 0.1, 3, nullptr);
    toliman_track_options options;
    toliman_track_options_init(&options, sizeof options);
    options.linear = linear.get();
    options.df = 0.1;
    options.nf = 3;
    const auto track = make<tracker>(toliman_track_create, &options);
    const toliman_period *sums = nullptr;
    check(toliman_track_get_period(track.get(), &sums));
    return cae && linear && components && period && toliman_period_count(sums) == 0 ? 0 : 1;
}

int a_failure_is_an_exception() {
    try {
        toliman_track_options options;
        toliman_track_options_init(&options, sizeof options);
        options.rows = -5;
        toliman::make<toliman::tracker>(toliman_track_create, &options);
    } catch (const toliman::error &error) {
        return error.status() == TOLIMAN_E_ARGUMENT && std::string(error.what()).find("options->rows = -5") == 0 ? 0
                                                                                                                 : 1;
    }
    return 1;
}

} // namespace

int main() {
    const int failed = make_one_of_each() + a_failure_is_an_exception();
    std::printf("%d failed\n", failed);
    return failed;
}
