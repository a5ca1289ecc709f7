// toliman night: a state folder in one line, for a log or a mail, with what has changed since the line before.
#include "common/output.hpp"
#include "downlink/folder_facts.hpp"
#include "downlink/instrument_trends.hpp"
#include "downlink/planet_job.hpp"
#include "downlink/state_folder.hpp"
#include "options/command.hpp"
#include "scenes/dates.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

constexpr char kSchema[] = "toliman-night/1";
constexpr double kLimitDays = 300; // of the planet that the line says is excluded

struct NightOptions {
    std::string folder;
    bool as_json = false;
};

// What the next line compares.
struct Night {
    std::string day; // of the last frame
    int64_t frames = 0;
    double log10_bayes = NAN; // of the best candidate
    bool is_planet = false;
};

std::optional<Night> night_before(const std::string &path, Progress &progress) {
    if (!exists(path))
        return std::nullopt;
    const std::string text = whole_text(path);
    const JsonTree tree(cJSON_ParseWithLength(text.data(), text.size()));
    const cJSON *const day = item_of(tree.get(), "day"), *const frames = item_of(tree.get(), "frames"),
                       *const odds = item_of(tree.get(), "log10_bayes");
    if (!cJSON_IsString(day) || !cJSON_IsNumber(frames)) {
        progress.warn(path + ": is not a result of toliman night: there is nothing to compare with");
        return std::nullopt;
    }
    return Night{day->valuestring, std::llround(frames->valuedouble), cJSON_IsNumber(odds) ? odds->valuedouble : NAN,
                 cJSON_IsTrue(item_of(tree.get(), "is_planet")) != 0};
}

std::string interval_text(const double (&points)[3], double factor) {
    return text_with_error(points[1] * factor, (points[2] - points[0]) / 2 * factor);
}

std::string planet_text(const PlanetSearch &search, const toliman_planet_candidate &planet) {
    std::string text = "planet " + interval_text(planet.period, 1) + " d";
    if (search.unit.in_uas())
        text += ", " + interval_text(planet.amplitude, search.uas(1)) + " uas";
    if (search.knows_mass(0))
        text += ", " + interval_text(planet.mass_a, 1) + " Earths on A";
    return text;
}

// The planet that the series excludes at a period in the middle of the prior.
std::string limit_text(const PlanetSearch &search) {
    if (search.info.period_min > kLimitDays || search.info.period_max < kLimitDays)
        return "";
    const toliman_planet_limit limit = limits_at(search, {kLimitDays}).front();
    std::string text = "; excludes ";
    text += search.unit.in_uas() ? formatted("%.2g uas", search.uas(limit.upper)) : formatted("%.3g", limit.upper);
    if (search.knows_mass(0))
        text += formatted(", %.2g Earths on A,", limit.upper_mass_a);
    return text + formatted(" at %g d", kLimitDays);
}

std::string change_text(double now, double before) {
    return std::isfinite(before) ? formatted(" (%+.1f)", now - before) : "";
}

class Report {
  public:
    Report(const NightOptions &options, Progress &progress)
        : folder_(options.folder), path_(options.folder + "/night.json"), before_(night_before(path_, progress)) {
        const toliman::tracker tracker = open_tracker(state_to_read(folder_), progress);
        complaint_ = model_complaint(goodness_of(tracker));
        for (const InstrumentTrend &trend : trends_of(tracker))
            if (trend.is_significant() && trend.name != "chi_square") // which is in the complaint
                drifts_ += (drifts_.empty() ? "; drifts: " : ", ") + trend.name +
                           formatted(" %+.3g +- %.1g ", trend.per_year, trend.sigma_per_year) + trend.unit +
                           (trend.unit.empty() ? "" : " ") + "per year";
        count(info_of(tracker));
        night_.frames = info_of(tracker).accepted;
        if (night_.frames > 0)
            night_.day = last_day(accepted_frames(tracker).get());
    }

    bool has_frames() const { return night_.frames > 0; }
    void add(const std::string &why) { found_ = "no search: " + why; }

    void add(const PlanetSearch &search) {
        if (search.candidates.empty()) {
            found_ = "no candidate" + limit_text(search);
            return;
        }
        const toliman_planet_candidate &best = search.candidates.front();
        night_.log10_bayes = best.log10_bayes;
        night_.is_planet = best.reasons == 0;
        const auto fitted = search.candidates.begin() + static_cast<std::ptrdiff_t>(search.fitted());
        is_refused_ = std::any_of(search.candidates.begin(), fitted, [](const auto &one) { return one.reasons != 0; });
        const std::string odds = formatted("log10 odds %.1f", best.log10_bayes) +
                                 change_text(best.log10_bayes, before_ ? before_->log10_bayes : NAN);
        found_ =
            night_.is_planet ? planet_text(search, best) + ", " + odds
            : search.fitted() > 0
                ? formatted("candidate at %.4g d, ", best.period[1]) + odds + ", is not a planet: " + reasons(search)
                : formatted("no planet: best at %.4g d, ", best.period[1]) + odds + limit_text(search);
    }

    bool is_wrong() const { return is_refused_ || !complaint_.empty(); }

    std::string line() const {
        std::string text = (has_frames() ? night_.day + " " : "") + folder_ +
                           formatted(": %lld frames", static_cast<long long>(night_.frames));
        if (before_)
            text += formatted(" (%+lld", static_cast<long long>(night_.frames - before_->frames)) +
                    (before_->day.empty() ? "" : " since " + before_->day) + ")";
        text += "; " + found_;
        if (before_ && before_->is_planet != night_.is_planet)
            text += night_.is_planet ? " (new)" : " (lost)";
        return text + left_out_ + "; " + (complaint_.empty() ? "instrument good" : "INSTRUMENT: " + complaint_) +
               drifts_;
    }

    void save() const {
        OutputFile file(path_);
        file.write(json().text());
        file.commit();
    }

    Json json() const {
        return Json("schema", kSchema, "day", night_.day, "frames", night_.frames, "log10_bayes", night_.log10_bayes,
                    "is_planet", night_.is_planet, "is_wrong", is_wrong(), "text", line());
    }

  private:
    // Frames that are not in the search: something is wrong if they are more than half.
    void count(const toliman_track_info &info) {
        int64_t all = 0;
        for (const auto &[frames, name] : {std::pair(info.unreduced, "unreduced"),
                                           {info.misfit, "misfits"},
                                           {info.outlier, "outliers"},
                                           {info.quarantined, "quarantined"},
                                           {info.rejected, "rejected"}}) {
            all += frames;
            if (frames > 0)
                left_out_ += (left_out_.empty() ? "; left out: " : ", ") +
                             formatted("%lld %s", static_cast<long long>(frames), name);
        }
        if (all > info.accepted || info.accepted == 0)
            complaint_ += std::string(complaint_.empty() ? "" : "; ") + "most frames are left out: see toliman status";
    }

    static std::string reasons(const PlanetSearch &search) {
        std::string text;
        for (const std::string &reason : search.reasons(0))
            text += (text.empty() ? "" : ", ") + reason;
        return text;
    }

    static std::string last_day(const toliman_measure *frames) {
        std::vector<int64_t> times(static_cast<size_t>(info_of(frames).n));
        toliman::check(toliman_measure_get_times(frames, times.data(), times.size()));
        return date_text(*std::max_element(times.begin(), times.end())).substr(0, 10);
    }

    std::string folder_, path_;
    std::optional<Night> before_;
    Night night_;
    std::string found_, complaint_, drifts_, left_out_;
    bool is_refused_ = false;
};

// The first nights have too few frames for a search.
void add_planet(const std::string &folder, Report &report, Progress &progress) {
    PlanetJobOptions search;
    search.file = folder;
    try {
        const PlanetJob job(search, false, progress);
        report.add(job.search());
    } catch (const Failure &failure) {
        if (failure.code() != kExitInput && failure.code() != kExitUsage)
            throw;
        report.add(failure.what());
    }
}

void night(NightOptions &options, Progress &progress) {
    options.folder = plain(options.folder);
    Report report(options, progress);
    if (report.has_frames())
        add_planet(options.folder, report, progress);
    else
        report.add("no frame is accepted");
    progress.clear();
    report.save();
    print_stdout(options.as_json ? report.json().text() : report.line() + "\n");
    if (report.is_wrong())
        throw Failure(kExitRejected, "");
}

} // namespace

void add_night(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "night");
    auto options = std::make_shared<NightOptions>();
    add_option(command, "DIR", options->folder, "")->required();
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, night);
}

} // namespace cli
