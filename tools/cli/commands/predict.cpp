// toliman predict: the separation of a binary as an observer sees it.
#include "options/command.hpp"
#include "scenes/leap_seconds.hpp"
#include "scenes/observer_options.hpp"
#include "scenes/sky_times.hpp"

namespace cli {

namespace {

struct PredictOptions {
    std::string system;
    ObserverOptions observer;
    SkyTimeOptions times;
    std::vector<std::string> without;
    bool as_json = false;
};

// In the order of their bits.
const std::vector<std::string> kEffects = {
    "earth_aberration", "spacecraft_aberration", "parallax",          "roemer",
    "light_time",       "radial_motion",         "transverse_motion", "deflection"};
constexpr size_t kPortion = 4096; // predictions between two looks for signals

uint32_t effects_of(const std::vector<std::string> &names) {
    uint32_t effects = 0;
    for (const std::string &name : names)
        effects |= 1u << (std::find(kEffects.begin(), kEffects.end(), name) - kEffects.begin());
    return effects;
}

std::vector<toliman_sky_prediction> predictions_of(const toliman_sky *sky, const std::vector<SkyTime> &times) {
    std::vector<int64_t> tai_ns;
    for (const SkyTime &time : times)
        tai_ns.push_back(time.tai_ns);
    std::vector<toliman_sky_prediction> seen(times.size(), toliman::sized<toliman_sky_prediction>());
    for (size_t i = 0; i < times.size(); i += kPortion) {
        stop_if_asked();
        toliman::check(toliman_sky_predict(sky, &tai_ns[i], std::min(kPortion, times.size() - i), &seen[i]));
    }
    return seen;
}

void print_prediction_table(const PredictOptions &options, const toliman_sky *sky, const std::vector<SkyTime> &times,
                            const std::vector<toliman_sky_prediction> &seen) {
    const auto info = toliman::result<toliman_sky_info>(toliman_sky_get_info, sky);
    size_t width = std::strlen("time");
    for (const SkyTime &time : times)
        width = std::max(width, time.text.size());
    std::string text = "# system    " + std::string(info.name[0] != '\0' ? info.name : options.system.c_str()) + "\n";
    const std::string orbit = options.observer.orbit(sky);
    text += "# observer  " + (orbit.empty() ? options.observer.text() : orbit) + "\n";
    text += "# without   " + (options.without.empty() ? "nothing" : joined(options.without)) + "\n";
    text += "# scale     " + options.times.scale + "\n";
    const auto cells = static_cast<int>(width);
    text += formatted("%-*s  separation_arcsec  position_angle_deg  geometric_arcsec    factor_ppm  offset_s     "
                      "approach_m_s  sun_deg\n",
                      cells, "time");
    for (size_t i = 0; i < times.size(); i++) {
        const toliman_sky_prediction &row = seen[i];
        text += formatted("%-*s  %17.9f  %18.7f  %16.9f  %12.6f  %11.6f  %12.3f  %7.3f\n", cells, times[i].text.c_str(),
                          row.separation_arcsec, row.position_angle_deg, row.geometric_arcsec, (row.factor - 1) * 1e6,
                          row.barycentric_offset_s, row.approach_m_s, row.sun_angle_deg);
        if (text.size() > size_t{1} << 16) {
            print_stdout(text);
            text.clear();
        }
    }
    print_stdout(text);
}

std::vector<Exact> partials_of(const toliman_sky_prediction &row) {
    std::vector<Exact> partials;
    for (const double partial : row.partials)
        partials.push_back(Exact{partial});
    return partials;
}

void print_prediction_json(const PredictOptions &options, const toliman_sky *sky, const std::vector<SkyTime> &times,
                           const std::vector<toliman_sky_prediction> &seen) {
    const auto info = toliman::result<toliman_sky_info>(toliman_sky_get_info, sky);
    Json json("schema", "toliman-predict/1", "version", toliman_version(), "system", options.system, "name",
              text_or_null(info.name), "orbit_digest", digest_text(info.orbit_digest));
    options.observer.set(json);
    options.observer.set_orbit(json, sky);
    json.set("without", options.without, "scale", options.times.scale);
    std::vector<Json> rows;
    for (size_t i = 0; i < times.size(); i++) {
        const toliman_sky_prediction &row = seen[i];
        rows.push_back(Json("time", times[i].text, "tai_ns", times[i].tai_ns, "separation_arcsec",
                            Exact{row.separation_arcsec}, "position_angle_deg", Exact{row.position_angle_deg},
                            "geometric_arcsec", Exact{row.geometric_arcsec}, "geometric_angle_deg",
                            Exact{row.geometric_angle_deg}, "factor", Exact{row.factor}, "barycentric_offset_s",
                            Exact{row.barycentric_offset_s}, "approach_m_s", Exact{row.approach_m_s}, "sun_angle_deg",
                            Exact{row.sun_angle_deg}, "partials", partials_of(row)));
    }
    json.set("predictions", rows);
    print_stdout(json.text());
}

void predict(const PredictOptions &options, Progress &progress) {
    options.observer.check();
    const std::vector<SkyTime> times = sky_times(options.times, LeapSeconds(options.observer.leap_seconds()).rows);
    const auto sky = options.observer.predictor(options.system, effects_of(options.without), progress);
    const auto seen = predictions_of(sky.get(), times);
    (options.as_json ? print_prediction_json : print_prediction_table)(options, sky.get(), times, seen);
}

} // namespace

void add_predict(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "predict");
    auto options = std::make_shared<PredictOptions>();
    add_system(*command, options->system);
    options->observer.add_to(*command);
    add_sky_times(*command, options->times);
    command->add_option("--without", options->without)
        ->type_name("EFFECT,...")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember(kEffects));
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, predict);
}

} // namespace cli
