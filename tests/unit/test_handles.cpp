// Tests the owning handles of toliman.hpp: creates, uses and destroys one of each. Does not use CMocka, whose longjmp
// would skip destructors.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include <toliman/toliman.hpp>

namespace {

constexpr char kScene[] = R"({"schema": "toliman-scene/1", "telescope": {"aperture_m": 0.125, "pupil_samples": 128},
    "band": {"wavelength_nm": 550}, "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}},
        "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}}},
    "binary": {"separation_arcsec": 6, "position_angle_deg": 30},
    "cadence": {"frames": 10, "peak_photons": 1e6}, "detector": {"shape": [256, 256], "pixel_scale_arcsec": 0.1}})";

// A pair of empty files in a temporary folder.
struct EmptyPair {
    EmptyPair() {
        const char *const above = std::getenv("TMPDIR");
        path = std::string(above != nullptr ? above : "/tmp") + "/toliman-handles-XXXXXX";
        if (::mkdtemp(&path[0]) == nullptr)
            throw std::runtime_error("no temporary folder");
        for (const std::string &name : {path + "/x_frames.bin", path + "/x_meta.jsonl"})
            std::fclose(std::fopen(name.c_str(), "wb"));
    }
    ~EmptyPair() {
        for (const std::string &name : {path + "/x_frames.bin", path + "/x_meta.jsonl", path})
            std::remove(name.c_str());
    }
    std::string path;
};

int make_one_of_each() {
    using namespace toliman;
    const auto sim = make<simulator>(toliman_sim_create_json, kScene, sizeof kScene - 1, nullptr, nullptr);
    const auto cae = make<autoencoder>(toliman_cae_create, sim.get(), 1u, nullptr);
    const auto linear = make<linear_estimator>(toliman_linear_create, sim.get(), nullptr);
    const toliman_sim *const scene = sim.get();
    const auto fit = make<frame_fit>(toliman_fit_create, &scene, nullptr, 1u, nullptr);
    const auto bank = make<network_bank>(toliman_bank_create, fit.get(), nullptr);
    const auto components = make<component_set>(toliman_components_create, sim.get(), nullptr);
    auto one = sized<toliman_mask_options>();
    one.iterations = 1;
    const auto mask = make<phase_mask>(toliman_mask_create, sim.get(), &one);
    const auto period = make<periodogram>(toliman_period_create, 0.0, 0.1, 3, nullptr);
    double times[10], values[10];
    for (int i = 0; i < 10; i++) {
        times[i] = 10 * i;
        values[i] = i % 3;
    }
    auto series = sized<toliman_measure_data>();
    series.n = 10;
    series.t = times;
    series.y = values;
    const auto measured = make<measurements>(toliman_measure_create, &series);
    auto searching = sized<toliman_planet_options>();
    searching.threads = 1;
    const auto planets = make<planet_set>(toliman_planet_create, measured.get(), &searching);
    const EmptyPair files;
    auto reading = sized<toliman_ingest_options>();
    reading.pixel = TOLIMAN_PIXEL_U16;
    const auto pair = make<pair_reader>(toliman_ingest_create, (files.path + "/x").c_str(), &reading);
    auto options = toliman::sized<toliman_track_options>();
    options.estimator.linear = linear.get();
    options.grid.df = 0.1;
    options.grid.nf = 3;
    const auto track = make<tracker>(toliman_track_create, &options);
    const toliman_period *sums = nullptr;
    check(toliman_track_get_period(track.get(), &sums));
    return cae && linear && fit && bank && components && mask && period && planets && pair &&
                   toliman::result<toliman_period_info>(toliman_period_get_info, sums).count == 0
               ? 0
               : 1;
}

int a_failure_is_an_exception() {
    try {
        auto options = toliman::sized<toliman_track_options>();
        options.frames.rows = -5;
        toliman::make<toliman::tracker>(toliman_track_create, &options);
    } catch (const toliman::error &error) {
        return error.status() == TOLIMAN_E_ARGUMENT && std::string(error.what()).find("options->frames.rows = -5") == 0
                   ? 0
                   : 1;
    }
    return 1;
}

int32_t throws(const char *, double, void *) {
    throw std::string("not an std::exception");
}

toliman_status throws_while_giving(size_t, size_t, double *, void *) {
    throw std::runtime_error("no more frames");
}

void throws_while_logging(int32_t, const char *, void *) {
    throw std::runtime_error("no log");
}

void *throws_while_allocating(size_t, size_t, void *) {
    throw std::runtime_error("no pool");
}

void release_nothing(void *, size_t, void *) {}

int32_t throws_while_estimating(const toliman_estimate_input *, toliman_estimate *, void *) {
    throw std::runtime_error("no star");
}

int ends_with(toliman_status status, const char *message) {
    const bool as_expected =
        status == TOLIMAN_E_CANCELLED && std::string(toliman_last_error()).find(message) != std::string::npos;
    if (!as_expected)
        std::printf("%s: %s\n", toliman_constant_name(status), toliman_last_error());
    return as_expected ? 0 : 1;
}

// An exception thrown by a callback cancels the call, and the object stays usable.
// promises: exceptions-cancel-calls, stopped-objects-stay-usable
int callbacks_may_throw() {
    using namespace toliman;
    const auto sim = make<simulator>(toliman_sim_create_json, kScene, sizeof kScene - 1, nullptr, nullptr);
    const auto cae = make<autoencoder>(toliman_cae_create, sim.get(), 1u, nullptr);
    auto training = toliman::sized<toliman_cae_train_options>();
    training.progress = throws;
    training.mode = TOLIMAN_CAE_MODE_UNSUPERVISED;
    training.frame_count = 4;
    training.frames = throws_while_giving;
    int failed = ends_with(toliman_cae_train(cae.get(), &training, nullptr), "threw an exception");
    training.progress = nullptr;
    failed +=
        ends_with(toliman_cae_train(cae.get(), &training, nullptr), "frames callback threw an exception: no more");

    auto fitting = toliman::sized<toliman_fit_options>(); // whose progress is part of that of all windows
    fitting.progress = throws;
    toliman_fit *fit = nullptr;
    const toliman_sim *const scene = sim.get();
    failed +=
        ends_with(toliman_fit_create(&scene, nullptr, 1, &fitting, &fit), "the progress callback threw an exception");
    if (std::string(toliman_last_error()).find("callback", 20) != std::string::npos)
        failed += ends_with(TOLIMAN_OK, "is stated twice");

    auto options = toliman::sized<toliman_sim_options>();
    options.log = throws_while_logging;
    std::string saturated = kScene; // which is a warning
    saturated.replace(saturated.find("\"shape\""), 0, "\"full_well_e\": 1000, ");
    toliman_sim *out = nullptr;
    failed +=
        ends_with(toliman_sim_create_json(saturated.c_str(), saturated.size(), nullptr, &options, &out), "no log");

    const toliman_allocator allocator = {sizeof allocator, 0, throws_while_allocating, release_nothing, nullptr};
    toliman_linear *linear = nullptr;
    auto in_pool = toliman::sized<toliman_linear_options>();
    in_pool.allocator = &allocator;
    failed += ends_with(toliman_linear_create(sim.get(), &in_pool, &linear), "no pool");
    toliman_cae_info info = {};
    info.struct_size = sizeof info;
    check(toliman_cae_get_info(cae.get(), nullptr, &info));
    return failed;
}

// promise: bad-estimates-reject-frames
int an_estimator_may_throw() {
    auto options = toliman::sized<toliman_track_options>();
    options.estimator.estimate = throws_while_estimating;
    options.estimator.id = 1;
    options.estimator.sigma = 1;
    options.limits.value = 1;
    options.frames.rows = options.frames.cols = 2;
    options.grid.f0 = options.grid.df = 0.1;
    options.grid.nf = 3;
    toliman_track *made = nullptr;
    toliman::check(toliman_track_create(&options, &made));
    const toliman::tracker tracker(made);
    const uint16_t pixels[] = {1, 2, 3, 4};
    auto frame = toliman::sized<toliman_frame>();
    frame.pixel = TOLIMAN_PIXEL_U16;
    frame.session = frame.roi = "s";
    frame.pixels = pixels;
    frame.rows = frame.cols = 2;
    auto outcome = toliman::sized<toliman_track_outcome>();
    size_t done = 0;
    toliman::check(toliman_track_push(tracker.get(), &frame, 1, &outcome, &done));
    return outcome.verdict == TOLIMAN_TRACK_VERDICT_REJECTED && outcome.reason == TOLIMAN_TRACK_REASON_ESTIMATE ? 0 : 1;
}

} // namespace

// Results by value; the place of an error, and the message without it.
int results_are_values_and_errors_have_details() {
    using namespace toliman;
    const auto period = make<periodogram>(toliman_period_create, 0.1, 0.1, int64_t{3}, nullptr);
    int failed = result<toliman_period_info>(toliman_period_get_info, period.get()).nf == 3 ? 0 : 1;
    toliman_period_sample samples[2] = {sized<toliman_period_sample>(), sized<toliman_period_sample>()};
    samples[1].flags = 1;
    try {
        check(toliman_period_push_samples(period.get(), samples, nullptr, 2));
        failed++;
    } catch (const error &caught) {
        failed +=
            caught.field() == "samples[1].flags" && caught.index() == 1 && caught.detail() == " = 0x1: unknown bits"
                ? 0
                : 1;
    }
    try {
        result<toliman_period_info>(toliman_period_get_info, static_cast<const toliman_period *>(nullptr));
        failed++;
    } catch (const error &caught) {
        failed += caught.index() == -1 && caught.detail() == " is NULL" ? 0 : 1;
    }
    return failed;
}

int main() {
    const int failed = results_are_values_and_errors_have_details() + make_one_of_each() + a_failure_is_an_exception() +
                       callbacks_may_throw() + an_estimator_may_throw();
    std::printf("%d failed\n", failed);
    return failed;
}
