// toliman status, toliman rebuild: what a state folder tells, and the same on another grid or clock.
#include <cstdio>

#include "command.hpp"
#include "failure.hpp"
#include "input.hpp"
#include "output.hpp"
#include "setup_options.hpp"
#include "state_folder.hpp"

namespace cli {

namespace {

constexpr char kStatusDescription[] = R"(What a folder of `toliman track` holds; also while it is written.

Examples:
  toliman status mission
  toliman status mission --json

Shows frames by what became of them, frame ids that are missing, and the period with its false alarm probability at one
look (single) and for who looks after every frame (sequential).)";

constexpr char kRebuildDescription[] = R"(Sums of a state folder made anew from its ledger, without the frames.

Examples:
  toliman rebuild mission --grid 1e-3:1e-5:50000
  toliman rebuild mission --clock clock.csv
  toliman rebuild mission --mission-days 1500 --clock camera

For another grid or epoch, or when a better clock correlation has come: a CSV of pairs camera_ns,tai_ns, or `camera` where
that time is TAI. What is not said stays. Frames that were rejected for their time must come again.)";

struct Options {
    std::string folder;
    bool as_json = false;
};

struct RebuildOptions : Options {
    SetupOptions setup;
};

void print(const toliman::tracker &tracker, const std::string &folder, bool as_json) {
    const toliman_track_info info = info_of(tracker);
    const PeriodFacts period(tracker, Fit::made);
    Json json;
    json.set("schema", std::string("toliman-track-status/1")).set("folder", folder);
    period.add_to(json);
    add_counts(info, json);
    json.set_count("lines", info.lines).set_count("capacity", info.capacity).set("sigma", info.sigma);
    if (as_json)
        return print_stdout(json.text());
    char text[900];
    const auto number = [](int64_t value) { return static_cast<long long>(value); };
    std::snprintf(text, sizeof text,
                  "%s\n  %s\n"
                  "  received    %12lld\n  accepted    %12lld\n  outlier     %12lld\n  quarantined %12lld\n"
                  "  repeated    %12lld\n  rejected    %12lld\n"
                  "  expected    %12lld\n  missing     %12lld\n  dropped     %12lld   by the camera\n"
                  "  sessions    %12lld   and regions\n",
                  folder.c_str(), period.text().c_str(), number(info.received), number(info.accepted),
                  number(info.outlier), number(info.quarantined), number(info.repeated), number(info.rejected),
                  number(info.expected), number(info.missing), number(info.dropped), number(info.sessions));
    print_stdout(text);
}

void status(Options &options) {
    options.folder = plain(options.folder);
    toliman_track_options how = known_state(options.folder);
    if (how.nf == 0)
        throw Failure(kExitState, options.folder +
                                      ": setup.tlms, which had grid and clock, is lost: `toliman rebuild " +
                                      options.folder + " --grid F0:DF:NF --clock CSV` makes it anew");
    how.flags = TOLIMAN_TRACK_READ_ONLY;
    print(open_tracker(how), options.folder, options.as_json);
}

void rebuild(RebuildOptions &options, Progress &progress) {
    options.folder = plain(options.folder);
    toliman_track_options how = known_state(options.folder);
    if (how.nf == 0 && !(options.setup.has_grid() && options.setup.has_clock()))
        throw Failure(kExitUsage, options.folder + ": setup.tlms, which had grid and clock, is lost: needs --clock and "
                                                   "--grid or --mission-days");
    options.setup.set(how, progress);
    how.flags = TOLIMAN_TRACK_REBUILD;
    const toliman::tracker tracker = open_tracker(how);
    toliman::check(toliman_track_save(tracker.get()));
    print(tracker, options.folder, options.as_json);
}

} // namespace

void add_status(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("status", kStatusDescription);
    auto options = std::make_shared<Options>();
    command->add_option("DIR", options->folder, "a state folder")->required();
    command->add_flag("--json", options->as_json, "as JSON on stdout");
    command->callback([&context, options] { context.action = [options] { status(*options); }; });
}

void add_rebuild(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("rebuild", kRebuildDescription);
    auto options = std::make_shared<RebuildOptions>();
    command->add_option("DIR", options->folder, "a state folder")->required();
    options->setup.add_to(*command);
    command->add_flag("--json", options->as_json, "as JSON on stdout");
    command->callback([&context, options] {
        context.action = [&context, options] {
            Progress progress(context.style());
            rebuild(*options, progress);
        };
    });
}

} // namespace cli
