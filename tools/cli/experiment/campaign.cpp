// Method: a series of frames is simulated once and pushed to all methods that lack a result for it. The values of a
// series with signal are regressed on the true displacement: slope, and scatter about the line. Without signal the
// scatter is the standard deviation, and the slope is measured on two noise-free expected images at +-1e-5 px. Series
// are ordered by the scene and the seed of their methods, so that each network is trained once and freed after its last
// series. The periodogram uses the grid of `run`; block means have fewer samples and a grid of their own.
#include "experiment/campaign.hpp"

#include <algorithm>
#include <cmath>
#include <future>

#include "common/failure.hpp"
#include "common/parallel.hpp"
#include "common/text.hpp"
#include "experiment/variants.hpp"
#include "frames/frame_loop.hpp"

namespace cli {

namespace {

constexpr uint64_t kControlFrames = 2000; // per seed of table robust: efficiency to 1/sqrt(2 * 2000) = 1.6 %
constexpr uint64_t kFewSeeds = 10;        // of tables with a single amplitude
constexpr double kStep = 1e-5;            // px, for the slope of a method on expected images
constexpr size_t kFewestValues = 5;       // of a series that is evaluated

std::vector<double> shape_of(const Scene &scene, const Cadence &cadence) {
    const double amplitude = scene.info.amplitude_px;
    if (!(amplitude > 0))
        throw Failure(kExitUsage,
                      scene.path + ": signal: experiment needs a signal with an amplitude above 0 px, which it varies");
    std::vector<double> shape = cadence.displacements;
    for (double &value : shape)
        value /= amplitude;
    return shape;
}

// Linear regression of the values on the true displacements.
void regress(const std::vector<double> &truth, const std::vector<double> &values, Row &row) {
    const double centre = mean(truth), level = mean(values);
    double product = 0, residual = 0;
    for (size_t i = 0; i < truth.size(); i++)
        product += (truth[i] - centre) * (values[i] - level);
    row.slope = product / squares(truth);
    for (size_t i = 0; i < truth.size(); i++) {
        const double gap = values[i] - level - row.slope * (truth[i] - centre);
        residual += gap * gap;
    }
    row.sigma = std::sqrt(residual / static_cast<double>(truth.size() - 2));
}

// Means of all complete blocks.
std::vector<double> block_means(const std::vector<double> &values, size_t block) {
    std::vector<double> means(values.size() / block);
    for (size_t i = 0; i < means.size() * block; i++)
        means[i / block] += values[i] / static_cast<double>(block);
    return means;
}

// The samples of a series whose frames gave a value.
struct Samples {
    Samples(const std::vector<double> &all_times, const std::vector<double> &all_truth,
            const std::vector<double> &all_values) {
        for (size_t i = 0; i < all_values.size(); i++) {
            if (std::isnan(all_values[i]))
                continue;
            times.push_back(all_times[i]);
            truth.push_back(all_truth[i]);
            values.push_back(all_values[i]);
        }
    }
    std::vector<double> times, truth, values;
};

void add_reference(const Table &table, double *images, size_t count) {
    const size_t pixels = table.reference.size();
    for (size_t k = 0; k < count; k++)
        for (size_t i = 0; i < pixels; i++)
            images[k * pixels + i] += table.reference[i];
}

// Slope of a method that does not learn from the series: its values per px on expected images, without noise; 0 if
// these give no value.
double slope_of(const Table &table, Method &method) {
    const Scene &scene = *table.frames;
    std::vector<double> images(2 * scene.pixels());
    const auto cols = static_cast<size_t>(scene.info.cols);
    toliman::check(toliman_sim_expect(scene.sim.get(), -kStep, images.data(), cols));
    toliman::check(toliman_sim_expect(scene.sim.get(), kStep, images.data() + scene.pixels(), cols));
    add_reference(table, images.data(), 2);
    const double times_days[2] = {}; // expected images are those of time 0
    method.push(images.data(), times_days, 2);
    const std::vector<double> values = method.series();
    const double slope = (values[1] - values[0]) / (2 * kStep);
    return std::isnan(slope) ? 0 : slope;
}

bool takes_part(const MethodKind &method, const Table &table, const Row &row) {
    if (row.amplitude_px == 0 && method.learns_from_series)
        return false;
    if (method.slow && (row.seed > kSlowSeeds || row.amplitude_px < kSlowLeastPx))
        return false;
    return table.ladder || method.knows_scene;
}

} // namespace

struct Campaign::Work {
    const Table *table;
    double amplitude_px; // 0 without signal
    uint64_t noise_seed;
    std::vector<Row> rows = {}; // still to be computed
};

Campaign::Campaign(std::shared_ptr<const Scene> scene, const CampaignOptions &options)
    : scene_(std::move(scene)), options_(options), cadence_(*scene_),
      grid_(default_grid({scene_->path, cadence_.times, {}, {}})), shape_(shape_of(*scene_, cadence_)),
      theory_(cadence_.times, shape_, grid_), amplitudes_(options.amplitudes) {
    if (!scene_->has("photon noise"))
        throw Failure(kExitUsage,
                      scene_->path + ": noise.photon = false: must be true: the Cramer-Rao bound assumes photon noise");
    if (std::count(amplitudes_.begin(), amplitudes_.end(), scene_->info.amplitude_px) == 0)
        amplitudes_.push_back(scene_->info.amplitude_px);
    make_tables();
}

void Campaign::make_tables() {
    const auto asked = [this](const char *name) {
        return std::count(options_.tables.begin(), options_.tables.end(), name) != 0;
    };
    if (asked("real"))
        add_table("real", "the scene as it is", scene_, scene_);
    if (!asked("equal") && !asked("robust"))
        return;
    if (asked("robust") && scene_->moves())
        throw Failure(kExitUsage, scene_->path + ": the stars move: the table robust needs stars at rest, for its " +
                                      "methods are made for time 0; give --tables real,equal");
    const SceneVariants variants(*scene_);
    const auto scene_of = [this](const std::string &json) { return std::make_shared<const Scene>(scene_->path, json); };
    if (asked("equal")) {
        const auto equal = scene_of(variants.equal_stars());
        add_table("equal", "both stars equally bright", equal, equal);
    }
    if (!asked("robust"))
        return;
    add_table("matched", "the scene as it is", scene_, scene_);
    add_table("jitter", "pointing 1e-3 px rms, fluxes 1e-4 rms", scene_of(variants.with({kJitter})), scene_);
    add_table("projected", "the same, fluxes and shift projected out", scene_of(variants.with({kJitter, kProjected})),
              scene_of(variants.with({kProjected})));
    add_mismatch("defocus", "defocus error of 0.03 wave rms", variants.defocused(0.03));
    add_mismatch("separation", "separation error of 1 px", variants.moved(1, 0, 1));
    add_mismatch("scale", "plate scale error of 1e-3", variants.moved(0, 0, 1.001));
    add_mismatch("pointing-0.1", "pointing error of 0.1 px", variants.moved(0, 0.1, 1));
    add_mismatch("pointing-0.5", "pointing error of 0.5 px", variants.moved(0, 0.5, 1));
}

// Frames of another scene, in two tables: as they are, and with their own expected image replaced by the reference
// image of the methods' scene, as after calibration with the mean frame.
void Campaign::add_mismatch(const std::string &name, const std::string &what, const std::string &json) {
    const auto frames = std::make_shared<const Scene>(scene_->path, json);
    add_table(name, what, frames, scene_);
    Table &table = add_table(name + "-mean", what + ", relative to their own mean", frames, scene_);
    table.reference = scene_->image(TOLIMAN_SIM_IMAGE_BOTH);
    const std::vector<double> own = frames->image(TOLIMAN_SIM_IMAGE_BOTH);
    for (size_t i = 0; i < own.size(); i++)
        table.reference[i] -= own[i];
}

Table &Campaign::add_table(const std::string &name, const std::string &what, std::shared_ptr<const Scene> frames,
                           std::shared_ptr<const Scene> methods) {
    Table table = {name, what, name == "real" || name == "equal", std::move(frames), std::move(methods), {}, {}, {}};
    const auto frames_a_series = static_cast<uint64_t>(scene_->info.frames);
    const uint64_t few = (kControlFrames + frames_a_series - 1) / frames_a_series;
    table.amplitudes = table.ladder ? options_.amplitudes : std::vector<double>{scene_->info.amplitude_px};
    const uint64_t seeds = table.ladder ? options_.seeds : std::min(options_.seeds, kFewSeeds);
    for (uint64_t s = 0; s < seeds; s++) {
        const uint64_t share = options_.blind / options_.seeds + (s < options_.blind % options_.seeds ? 1 : 0);
        table.blind.push_back(table.ladder ? share : std::min(share, few));
    }
    tables_.push_back(std::move(table));
    return tables_.back();
}

Json Campaign::arguments() const {
    return Json("schema", "toliman-experiment-journal/1", "version", toliman_version(), "scene", scene_->info.name,
                "scene_digest", digest_text(scene_->info.scene_digest), "crb_px",
                scene_->bounds().crb_projected_px, // changes also with the files that the scene names
                "amplitudes_px", options_.amplitudes, "methods", options_.methods, "tables", options_.tables, "seeds",
                static_cast<double>(options_.seeds), "blind", static_cast<double>(options_.blind));
}

// The work still to be done, by the scene and the seed of the methods, which are created once for each.
Campaign::Groups Campaign::left(const Journal &journal) const {
    Groups groups;
    std::map<const Scene *, size_t> order; // of the methods' scenes
    for (const Table &table : tables_) {
        const size_t scene = order.emplace(table.methods.get(), order.size()).first->second;
        for (uint64_t seed = 1; seed <= table.blind.size(); seed++) {
            const auto add = [&](double amplitude_px, uint64_t series, uint64_t use) {
                Work work = {&table, amplitude_px, seed + (use << 32)};
                for (const std::string &method : options_.methods) {
                    const Row row = {table.name, method, amplitude_px, seed, series};
                    if (takes_part(method_kind(method), table, row) && !journal.contains(row))
                        work.rows.push_back(row);
                }
                if (!work.rows.empty())
                    groups[{scene, seed}].push_back(std::move(work));
            };
            for (const double amplitude : table.amplitudes) {
                const auto at = std::find(amplitudes_.begin(), amplitudes_.end(), amplitude);
                add(amplitude, 0, static_cast<uint64_t>(at - amplitudes_.begin()));
            }
            for (uint64_t series = 0; series < table.blind[seed - 1]; series++)
                add(0, series, amplitudes_.size() + series);
        }
    }
    return groups;
}

void Campaign::run(Journal &journal, Progress &progress) const {
    Groups groups = left(journal);
    double total = 0, done = 0;
    for (const auto &[key, group] : groups)
        for (const Work &work : group)
            total += static_cast<double>(work.rows.size());
    // The methods of the next group are made, and trained on one thread, while the series of this one are computed.
    std::future<Methods> next;
    for (auto at = groups.begin(); at != groups.end(); ++at) {
        const Methods methods = next.valid() ? next.get() : methods_of(at->second);
        if (std::next(at) != groups.end())
            next = std::async([&group = std::next(at)->second] { return methods_of(group); });
        for (Work &work : at->second) {
            const std::string note = formatted("%s, %g px, seed %llu", work.table->name.c_str(), work.amplitude_px,
                                               static_cast<unsigned long long>(work.rows[0].seed));
            const auto share = static_cast<double>(work.rows.size());
            run_series(work, methods,
                       [&](double part) { progress.show("experiment", (done + part * share) / total, note); });
            done += share;
            for (const Row &row : work.rows)
                journal.add(row);
        }
    }
}

// The methods of all works of a group, which have one scene and seed.
Campaign::Methods Campaign::methods_of(const std::vector<Work> &group) {
    Methods methods;
    SharedFrames shared;
    for (const Work &work : group)
        for (const Row &row : work.rows)
            if (methods.count(row.method) == 0)
                methods[row.method] = method_kind(row.method).make(*work.table->methods, row.seed, shared);
    return methods;
}

// Simulates one series of frames and pushes it to all methods at once.
void Campaign::run_series(Work &work, const Methods &methods, const std::function<void(double)> &show) const {
    const size_t count = shape_.size();
    const auto method_of = [&](size_t i) -> Method & { return *methods.at(work.rows[i].method); };
    if (work.amplitude_px == 0)
        for (size_t i = 0; i < work.rows.size(); i++)
            work.rows[i].slope = slope_of(*work.table, method_of(i));
    std::vector<double> truth = shape_;
    for (double &value : truth)
        value *= work.amplitude_px;
    for_frames(*work.table->frames, work.noise_seed, 0, count, truth.data(), [&](size_t at, size_t n, double *images) {
        add_reference(*work.table, images, n);
        run_parallel(work.rows.size(), [&](size_t i) { method_of(i).push(images, &cadence_.times[at], n); });
        show(static_cast<double>(at + n) / static_cast<double>(count));
    });
    run_parallel(work.rows.size(), [&](size_t i) { evaluate(work, truth, method_of(i), work.rows[i]); });
}

// The row of a method that has the frames of a series.
void Campaign::evaluate(const Work &work, const std::vector<double> &truth, Method &method, Row &row) const {
    Progress quiet(Progress::Style::none);
    const size_t block = method.block();
    const Samples samples(block_means(cadence_.times, block), block_means(truth, block), method.series());
    const std::vector<double> &values = samples.values;
    if (values.size() < kFewestValues)
        return; // finds nothing: log10 FAP and all other numbers remain 0
    const Series series = {scene_->path, samples.times, values, {}};
    const toliman_period_peak peak = find_period(series, block > 1 ? default_grid(series) : grid_, {}, quiet).peak;
    row.period_days = peak.period;
    row.log10_fap = peak.log10_fap;
    row.mean = mean(values);
    if (work.amplitude_px == 0)
        row.sigma = deviation(values);
    else
        regress(samples.truth, values, row);
    row.sigma *= std::sqrt(static_cast<double>(block)); // of one frame
}

} // namespace cli
