// toliman merge: the sums of shards into one.
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <string_view>

#include "command.hpp"
#include "failure.hpp"
#include "output.hpp"
#include "periodogram.hpp"

namespace cli {

namespace {

struct Options {
    std::vector<std::string> files;
    std::string out;
};

constexpr char kDescription[] = R"(Add up the saved sums of periodograms.

Example:
  toliman period monday.csv --f0 1e-3 --df 1e-4 --nf 5000 --follow --save-state monday.tlmp
  toliman period tuesday.csv --from-state monday.tlmp --save-state both.tlmp
  toliman merge here.tlmp there.tlmp --out all.tlmp
  toliman period --from-state all.tlmp

The first file's grid and references stay; its bounds are widened to what the others allow. With equal ones the result
has the bits that all samples in one periodogram would give, in any shards and order; others of the same frequencies are
turned to the first's. No file may be given twice, as itself or as a copy, and sigmas stand in all files or in none.)";

// The same samples make the same bytes: a state given twice would count them twice.
class Once {
  public:
    void check(const toliman::periodogram &state, const std::string &file) {
        const std::vector<unsigned char> bytes = state_bytes(state);
        const std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
        const auto [other, is_new] = seen_.emplace(std::hash<std::string_view>()(text), file);
        if (!is_new && toliman_period_count(state.get()) > 0)
            malformed(file, "holds the same samples as " + other->second);
    }

  private:
    std::map<size_t, std::string> seen_; // files by a hash of their content
};

// Samples without sigma would weigh as much as those of the smallest one.
void check_weights(const toliman_period_info &before, const toliman_period_info &more, const std::string &file) {
    if (before.count > 0 && more.count > 0 && before.weighted != more.weighted)
        malformed(file, std::string("its samples have ") + (more.weighted != 0 ? "a" : "no") +
                            " sigma, those before have " + (more.weighted != 0 ? "none" : "one"));
}

// No sums yet, with the grid and references of the first file and bounds that hold what any file may hold: the first's
// own where these are enough.
toliman::periodogram empty_sum(const std::vector<std::string> &files) {
    Once once;
    toliman_period_info first = {}, counted = {}; // the latter with samples
    toliman_period_options how;
    toliman_period_options_init(&how);
    for (const std::string &file : files) {
        const toliman::periodogram state = load_state(file);
        const toliman_period_info info = info_of(state);
        once.check(state, file);
        if (first.nf == 0) {
            first = info;
            how.value_bound = info.value_bound;
            how.sigma_floor = info.sigma_floor;
        }
        check_weights(counted, info, file);
        counted = info.count > 0 ? info : counted;
        const double farthest = std::fabs(info.value_offset - first.value_offset) + info.value_bound;
        if (farthest > how.value_bound)
            how.value_bound = std::exp2(std::ceil(std::log2(farthest)));
        how.sigma_floor = std::fmin(how.sigma_floor, info.sigma_floor);
        how.sigma_ceiling = std::fmax(how.sigma_ceiling, info.sigma_ceiling);
        how.flags |= info.flags & TOLIMAN_PERIOD_WIDE;
    }
    how.flags |= first.flags;
    how.time_offset = first.time_offset;
    how.value_offset = first.value_offset;
    how.time_offset_ns = first.time_offset_ns;
    how.unit_ns = first.unit_ns;
    return make_periodogram({first.f0, first.df, first.nf}, how);
}

void merge(const Options &options) {
    if (options.files.size() < 2)
        throw Failure(kExitUsage, "merge: one state alone: give two or more");
    check_output(options.out);
    const toliman::periodogram sum = empty_sum(options.files);
    for (const std::string &file : options.files)
        if (toliman_period_merge(sum.get(), load_state(file).get()) != TOLIMAN_OK)
            malformed(file, toliman_last_error());
    save_state(sum, options.out);
    std::fprintf(stderr, "%s: %lld samples\n", options.out.c_str(),
                 static_cast<long long>(toliman_period_count(sum.get())));
}

} // namespace

void add_merge(CLI::App &app, Context &context) {
    CLI::App *command = app.add_subcommand("merge", kDescription);
    auto options = std::make_shared<Options>();
    command->add_option("STATES", options->files, "files of `toliman period --save-state`")->required();
    command->add_option("--out", options->out, "the file to write (.tlmp); - is standard output")->required();
    command->callback([&context, options] { context.action = [options] { merge(*options); }; });
}

} // namespace cli
