// toliman-mpi: distributes the frames of a scene over the ranks of an MPI job and adds up their exact sums.
#include <cstdio>
#include <memory>
#include <optional>
#include <sstream>

#include "common/json.hpp"
#include "common/library.hpp"
#include "common/output.hpp"
#include "common/process.hpp"
#include "frames/network.hpp"
#include "options/command.hpp"
#include "options/help.hpp"
#include "options/suggest.hpp"
#include "planet_map.hpp"
#include "ranks.hpp"
#include "scenes/scene.hpp"
#include "series/periodogram.hpp"

namespace {

using namespace cli;
using toliman::check;

constexpr char kDescription[] =
    R"(Simulate a scene, estimate its frames and find the period, on all ranks of an MPI job.

Examples:
  # least squares on four processors
  mpirun -n 4 toliman-mpi chapter.json
  # a trained network, another seed, the result as one JSON line
  mpirun -n 4 toliman-mpi chapter.json --weights chapter.tlmw --seed 7 --json
  # 20 series with 20 seeds, one JSON line each
  mpirun -n 4 toliman-mpi chapter.json --campaign 20 >campaign.jsonl
  # a detection map on four processors, with the options and the output of `toliman planet`
  mpirun -n 4 toliman-mpi planet mission --map --out mission.planets

Each rank simulates and estimates a range of the frames on one processor. The exact sums of all ranks are added up, so
the output has the same bits for any number of ranks. The frequency grid is that of `toliman run`.

Output: the highest peak with its period, widths and log10 FAP, and a digest of the sums; with --json as one line of
schema toliman-mpi/2. Exit codes are those of `toliman`.)";

struct Options {
    std::string scene, weights;
    uint64_t seed = 0;
    int64_t campaign = 1;
    bool seed_given = false, as_json = false;
};

// The text of --help or --version if the command line asks for it, otherwise empty.
std::string parse(int argc, char **argv, Options &options) {
    CLI::App app(kDescription, "toliman-mpi");
    app.formatter(std::make_shared<HelpFormatter>());
    app.set_version_flag("--version", std::string("toliman-mpi ") + toliman_version());
    add_scene(app, options.scene);
    CLI::Option *seed = add_seed(app, options.seed)->description("seed of the noise; default: the scene's");
    CLI::Option *campaign = app.add_option("--campaign", options.campaign,
                                           "K: K series with the seeds from --seed on; a JSON line for each");
    campaign->check(CLI::Range(1, 1000000));
    app.add_option("--weights", options.weights,
                   "weights file of `toliman train`; default: least squares on the scene's derivative image")
        ->type_name("FILE");
    app.add_flag("--json", options.as_json, "print a JSON line, schema toliman-mpi/2");
    describe(app, "mpi");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success &success) {
        std::ostringstream text;
        app.exit(success, text);
        return text.str();
    } catch (const CLI::ParseError &error) {
        throw Failure(kExitUsage, command_line_error(error, app, argc, argv));
    }
    options.seed_given = seed->count() > 0;
    options.as_json = options.as_json || campaign->count() > 0;
    return "";
}

// One thread per rank; only one rank prints messages.
toliman_sim_options rank_options(bool prints, Progress &progress) {
    auto options = toliman::sized<toliman_sim_options>();
    options.threads = 1;
    if (prints)
        options.log = Progress::log;
    options.log_data = &progress;
    return options;
}

class Job {
  public:
    Job(const Options &options, bool prints)
        : progress_(Progress::Style::none), scene_(options.scene, rank_options(prints, progress_)),
          first_seed_(options.seed_given ? options.seed : scene_.info.seed) {
        check_cadence(scene_, "toliman-mpi");
        if (first_seed_ > UINT64_MAX - static_cast<uint64_t>(options.campaign - 1))
            throw Failure(kExitUsage, "--campaign " + std::to_string(options.campaign) + ": the last seed must be at " +
                                          "most 18446744073709551615, the first is " + std::to_string(first_seed_));
        times_ = Cadence(scene_).times;
        grid_ = default_grid(scene_.path, times_);
        const auto warnings = with_warnings<toliman_linear_options>(progress_);
        if (options.weights.empty())
            template_ = toliman::make<toliman::linear_estimator>(toliman_linear_create, scene_.sim.get(),
                                                                 prints ? &warnings : nullptr);
        else
            load(options.weights);
    }

    int64_t frames() const noexcept { return scene_.info.frames; }
    uint64_t seed(int64_t series) const noexcept { return first_seed_ + static_cast<uint64_t>(series); }

    // A periodogram without samples. Its options do not depend on the values, since no rank knows all of them.
    toliman::periodogram empty() const {
        auto options = toliman::sized<toliman_period_options>();
        options.flags = TOLIMAN_PERIOD_DOUBLE_LIMB; // as options_for
        options.time_offset = times_.front();
        return make_periodogram(grid_, options);
    }

    void push(uint64_t seed, int64_t begin, int64_t end, const toliman::periodogram &into) const {
        std::vector<double> image(scene_.pixels());
        for (int64_t k = begin; k < end; k++) {
            check(toliman_sim_frame(scene_.sim.get(), nullptr, seed, k, 1, image.data()));
            check(toliman_period_push(into.get(), times_[static_cast<size_t>(k)], estimate(image.data()), 1));
        }
    }

    void print(uint64_t seed, const toliman::periodogram &sum, bool as_json) const {
        toliman_period_peak peak = {};
        peak.struct_size = sizeof peak;
        check(toliman_period_query_peak(sum.get(), &peak));
        print_stdout(as_json ? line(seed, sum, peak) : summary(seed, sum, peak));
    }

  private:
    void load(const std::string &weights) {
        network_.emplace(weights);
        const toliman_cae_info &info = network_->info;
        if (info.rows != scene_.info.rows || info.cols != scene_.info.cols)
            throw Failure(kExitInput, weights + ": is for frames of " + std::to_string(info.rows) + "x" +
                                          std::to_string(info.cols) + ", those of " + scene_.path + " are " +
                                          std::to_string(scene_.info.rows) + "x" + std::to_string(scene_.info.cols));
    }

    double estimate(const double *frame) const {
        const toliman_image image = plain_image(frame);
        double value;
        check(network_ ? toliman_cae_encode(network_->cae.get(), &image, 1, &value, nullptr)
                       : toliman_linear_encode(template_.get(), &image, 1, &value, nullptr));
        return value;
    }

    // FNV-1a of the state's bytes.
    static std::string digest(const toliman::periodogram &sum) {
        uint64_t hash = 0xcbf29ce484222325;
        for (const unsigned char byte : state_bytes(sum))
            hash = (hash ^ byte) * 0x100000001b3;
        char text[20];
        std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
        return text;
    }

    std::string line(uint64_t seed, const toliman::periodogram &sum, const toliman_period_peak &peak) const {
        Json json, grid;
        grid.set("f0", grid_.f0).set("df", grid_.df).set("nf", static_cast<double>(grid_.nf));
        json.set("schema", "toliman-mpi/2").set("version", toliman_version());
        json.set("scene", scene_.info.name).set("estimator", network_ ? "cae" : "template");
        json.set("seed", seed).set("frames", static_cast<double>(info_of(sum).count));
        json.set("period_days", peak.period).set("half_width_period_days", peak.half_width_period);
        json.set("fwhm_period_days", peak.fwhm_period).set("at_edge", (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0);
        json.set("power", peak.power).set("log10_fap", peak.log10_fap);
        json.set("grid", grid).set("digest", digest(sum));
        return json.line();
    }

    std::string summary(uint64_t seed, const toliman::periodogram &sum, const toliman_period_peak &peak) const {
        char text[512];
        std::snprintf(text, sizeof text,
                      "scene         %.80s: %lld frames, seed %llu, %s\n"
                      "highest peak  %.2f days, half width %.2f, FWHM %.2f, log10 FAP %.1f%s\n"
                      "digest        %s\n",
                      scene_.info.name, static_cast<long long>(info_of(sum).count),
                      static_cast<unsigned long long>(seed), network_ ? "autoencoder" : "template", peak.period,
                      peak.half_width_period, peak.fwhm_period, peak.log10_fap,
                      (peak.flags & TOLIMAN_PERIOD_AT_EDGE) != 0 ? ", at the edge of the grid" : "",
                      digest(sum).c_str());
        return text;
    }

    Progress progress_;
    Scene scene_;
    uint64_t first_seed_;
    std::vector<double> times_;
    FrequencyGrid grid_ = {};
    std::optional<Network> network_;
    toliman::linear_estimator template_;
};

void run(const mpi::Ranks &ranks, int argc, char **argv) {
    if (mpi::is_planet(argc, argv))
        return mpi::run_planet(ranks, argc, argv);
    Options options;
    std::optional<Job> job;
    ranks.together([&] {
        const std::string text = parse(argc, argv, options);
        if (text.empty())
            job.emplace(options, ranks.first());
        else if (ranks.first())
            print_stdout(text);
    });
    if (!job)
        return;
    for (int64_t series = 0; series < options.campaign; series++) {
        const uint64_t seed = job->seed(series);
        toliman::periodogram own;
        ranks.together([&] {
            own = job->empty();
            job->push(seed, ranks.share_begin(job->frames()), ranks.share_end(job->frames()), own);
        });
        const toliman::periodogram sum = ranks.sum(own);
        ranks.together([&] {
            if (sum)
                job->print(seed, sum, options.as_json);
        });
    }
}

// Without a launcher there are no other ranks to agree with: --help and an invalid command line need no MPI.
bool answered_alone(int argc, char **argv) {
    Options options;
    const std::string text = mpi::launched()              ? ""
                             : mpi::is_planet(argc, argv) ? mpi::planet_help(argc, argv)
                                                          : parse(argc, argv, options);
    print_stdout(text);
    return !text.empty();
}

} // namespace

int main(int argc, char **argv) {
    try {
        const Ending ending = ending_of([&] { // a failure inside Ranks::together arrives as Ended
            prepare_process(argv);
            if (answered_alone(argc, argv))
                return;
            const mpi::Ranks ranks;
            run(ranks, argc, argv);
        });
        if (!ending.why.empty())
            std::fprintf(stderr, "toliman-mpi: %s\n", ending.why.c_str());
        return ending.code;
    } catch (const mpi::Ended &ended) {
        return ended.code;
    }
}
