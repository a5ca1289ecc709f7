// toliman merge: the sums of shards into one.
#include <cstdio>

#include "command.hpp"
#include "failure.hpp"
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

The first file's grid and references stay. With equal ones the result has the bits that all samples in one periodogram
would give, in any shards and order; others of the same frequencies are turned to the first's.)";

void merge(const Options &options) {
    const toliman::periodogram sum = load_state(options.files.front());
    for (size_t i = 1; i < options.files.size(); i++)
        if (toliman_period_merge(sum.get(), load_state(options.files[i]).get()) != TOLIMAN_OK)
            malformed(options.files[i], toliman_last_error());
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
