// include/toliman/track.h: creation of trackers, and the calls that modify them.
//
// Options are checked, and completed with the estimator's properties, before the folder is opened; a missing grid or
// clock then comes from the folder. All frames of a push are checked before the first one is processed, so that an
// impossible frame leaves the tracker unchanged.
#include <cstdio>

#include <toliman/track.h>

#include "api/common.hpp"
#include "api/grid_flags.hpp"
#include "api/handles.hpp"
#include "api/track_estimators.hpp"
#include "api/track_frames.hpp"
#include "api/track_handle.hpp"
#include "api/track_results.hpp"
#include "base/workers.hpp"
#include "track/tracker.hpp"

using namespace toliman;
using namespace toliman::api;

namespace {

constexpr Choice<track::Sync> kSyncs = {TOLIMAN_TRACK_SYNC_GROUP, TOLIMAN_TRACK_SYNC_NONE, "TOLIMAN_TRACK_SYNC_..."};

// Exclusive use of a tracker and of its periodogram, which another thread may be querying.
class ExclusiveUse {
  public:
    explicit ExclusiveUse(toliman_track *track)
        : track_(track, "track"), period_(&track->period, "the tracker's period") {}
    toliman_track *operator->() const noexcept { return track_.operator->(); }
    toliman_track &operator*() const noexcept { return *track_; }

  private:
    Use<toliman_track> track_;
    Use<toliman_period> period_;
};

constexpr int64_t kCapacity = 1 << 20;

void check_functions(const toliman_track_options &options) {
    if (options.grid.trend <= 0 && (options.grid.trend_start != 0 || options.grid.trend_end != 0))
        fail(Status::argument, "{options->grid.trend_start} = %g, trend_end = %g: must be 0 without a trend",
             options.grid.trend_start, options.grid.trend_end);
}

toliman_track_options known_options(const toliman_track_options *given) {
    required(given, "options");
    toliman_track_options options = accept(given, "options");
    if (options.threads == 0 && options.estimator.estimate != nullptr)
        options.threads = 1;
    options.threads = worker_count(options.threads);
    constexpr uint32_t kOfFolder = TOLIMAN_TRACK_READ_ONLY | TOLIMAN_TRACK_REBUILD;
    if (options.clock.count > 0)
        required(options.clock.pairs, "options->clock.pairs");
    if (memchr(options.estimator.values, 0, sizeof options.estimator.values) == nullptr)
        fail(Status::argument, "{options->estimator.values}: must have at most %zu characters",
             sizeof options.estimator.values - 1);
    if (options.limits.chi_square != track::kLimitOfMedian && options.limits.chi_square < 0)
        fail(Status::argument,
             "{options->limits.chi_square} = %g: must be above 0, 0 = that of the folder, or -1 = that of the "
             "median",
             options.limits.chi_square);
    check_functions(options);
    if (options.folder == nullptr && (options.flags & kOfFolder) != 0)
        fail(Status::argument, "{options->folder} is NULL: required by READ_ONLY and REBUILD");
    return options;
}

track::Terms terms_of(const toliman_track_options &options) {
    track::Terms terms;
    track::Geometry &geometry = terms.geometry;
    TOLIMAN_COPY(geometry, options.frames, rows, cols, crop_row, crop_col, bin, bit_depth);
    geometry.out_rows = static_cast<size_t>(options.frames.image_rows);
    geometry.out_cols = static_cast<size_t>(options.frames.image_cols);
    geometry.zero_run = (options.flags & TOLIMAN_TRACK_ALLOW_ZERO_RUNS) != 0 ? 0 : options.frames.zero_run_bytes;
    terms.sigma = options.estimator.sigma;
    terms.value_limit = options.limits.value;
    return terms;
}

// The grid of the options; none if nf = 0.
std::optional<period::Grid> grid_of(const toliman_track_options &options, const track::Terms &terms) {
    if (options.grid.nf == 0)
        return std::nullopt;
    period::Grid grid;
    TOLIMAN_COPY(grid, options.grid, f0, df, nf);
    set_flags(grid, options.grid.flags);
    TOLIMAN_COPY(grid, options.grid, time_offset_ns, unit_ns);
    grid = track::for_terms(grid, terms);
    in_struct("options->grid.", [&] { grid.check(); });
    return grid;
}

// The clock of the options; none without points.
std::optional<track::Clock> clock_of(const toliman_track_options &options) {
    if (options.clock.count == 0)
        return std::nullopt;
    std::vector<track::ClockPoint> points(options.clock.count);
    for (size_t i = 0; i < points.size(); i++)
        points[i] = {options.clock.pairs[2 * i], options.clock.pairs[2 * i + 1]};
    return track::Clock(std::move(points));
}

void check_measured(const toliman_track_options &options, const track::Columns &columns) {
    if (options.reduction.sky != nullptr && columns.find(track::kMeasured) == columns.count())
        fail(Status::argument,
             "{options->reduction.sky}: needs a value %s: use fit, or estimate with this name in values",
             track::kMeasured);
}

void set_terms(toliman_track_options &options, const track::Terms &terms, const track::Columns &columns) {
    const track::Geometry &geometry = terms.geometry;
    options.estimator.id = terms.estimator;
    columns.further().copy(options.estimator.values, sizeof options.estimator.values - 1);
    options.estimator.sigma = terms.sigma;
    options.limits.value = terms.value_limit;
    TOLIMAN_COPY(options.frames, geometry, rows, cols, crop_row, crop_col, bin, bit_depth);
    options.frames.image_rows = static_cast<int64_t>(geometry.out_rows);
    options.frames.image_cols = static_cast<int64_t>(geometry.out_cols);
    options.frames.zero_run_bytes = static_cast<uint32_t>(geometry.zero_run);
    if (geometry.zero_run == 0)
        options.flags |= TOLIMAN_TRACK_ALLOW_ZERO_RUNS;
}

void set_setup(toliman_track_options &options, const track::Setup &setup) {
    const period::Basis &basis = setup.grid.basis;
    TOLIMAN_COPY(options.grid, setup.grid, f0, df, nf, time_offset_ns, unit_ns);
    options.grid.flags = flags_of(setup.grid);
    options.frames.stamp = kStamps.to_constant(setup.timing.stamp);
    options.frames.exposure_s = setup.timing.exposure_s;
    options.reduction.plate_scale_arcsec = setup.reference.scale_arcsec;
    options.reduction.scale_sigma = setup.errors.scale_sigma;
    options.limits.chi_square = setup.chi_limit > 0 ? setup.chi_limit : track::kLimitOfMedian;
    options.grid.trend = basis.trend > 0 ? basis.trend : setup.reference.is_given() && basis.columns == 0 ? -1 : 0;
    options.grid.trend_start = basis.start;
    options.grid.trend_end = basis.end;
}

toliman_track_options options_of(Store &store) {
    toliman_track_options options = {};
    const std::optional<track::Setup> setup = track::load_setup(store);
    const track::LedgerFile ledger(store);
    const auto lines = static_cast<int64_t>(ledger.count());
    options.ledger.capacity = std::min(std::max(kCapacity, 2 * lines), track::FrameIndex::kMax);
    set_terms(options, ledger.terms(), ledger.columns());
    if (setup)
        set_setup(options, *setup);
    return options;
}

// Stores the options in effect for get_options: defaults resolved, and without the caller's pointers.
void keep_options(toliman_track &made, const toliman_track_options &given) {
    const track::Plan &plan = made.tracker->plan();
    for (const track::ClockPoint &point : plan.clock.points())
        made.clock.insert(made.clock.end(), {point.camera_ns, point.tai_ns});
    if (given.folder != nullptr)
        made.folder = given.folder;
    toliman_track_options &options = made.options;
    options.flags = given.flags;
    options.ledger.capacity = plan.capacity;
    options.threads = plan.workers;
    TOLIMAN_COPY(options.ledger, given.ledger, sync, group);
    set_terms(options, plan.terms, made.tracker->columns());
    set_setup(options, made.tracker->setup());
    options.folder = given.folder != nullptr ? made.folder.c_str() : nullptr;
    options.clock.pairs = made.clock.empty() ? nullptr : made.clock.data();
    options.clock.count = plan.clock.points().size();
}

track::Request request_of(const toliman_track_options &options, const track::Source &source,
                          const track::Terms &terms) {
    track::Request request;
    request.grid = grid_of(options, terms);
    request.clock = clock_of(options);
    if (options.frames.stamp != 0)
        request.stamp = kStamps.to_enum(options.frames.stamp);
    request.exposure_s = options.frames.exposure_s;
    request.scale_arcsec = options.reduction.plate_scale_arcsec;
    request.scale_sigma = options.reduction.scale_sigma;
    request.chi_limit = options.limits.chi_square;
    TOLIMAN_COPY(request, options.grid, trend, trend_start, trend_end);
    request.folder = options.folder;
    request.setup_folder = options.ledger.setup_folder;
    request.has_estimator = source.estimate || options.estimator.estimate != nullptr;
    if (const toliman_sky *const sky = options.reduction.sky; sky != nullptr)
        request.orbit = [sky](const std::string &system) { return sky->orbit(*sky->predictor, system); };
    return request;
}

std::unique_ptr<toliman_track> make_track(const toliman_track_options &options) {
    track::Plan plan;
    TOLIMAN_COPY(plan, options.ledger, capacity, group);
    plan.workers = options.threads;
    plan.sync = kSyncs.to_enum(options.ledger.sync);
    track::Source source = source_of(options, plan.workers);
    if (source.parameters.empty() && options.ledger.setup_folder != nullptr)
        source.parameters = track::parameters_in(options.ledger.setup_folder);
    const bool is_reduced = options.reduction.sky != nullptr;
    plan.terms = track::completed(terms_of(options), source, is_reduced);
    check_measured(options, track::columns_of(options.estimator.values, source, false));

    const track::Request request = request_of(options, source, plan.terms);
    track::StateFolder place;
    const Access access = (options.flags & TOLIMAN_TRACK_READ_ONLY) != 0 ? Access::read : Access::write;
    if (options.folder != nullptr) // opened after the checks above, since opening for writing creates it
        place = track::open_state_folder(open_folder(options.folder, access), access, plan.terms);
    place.log = {options.log, options.log_data};
    place.rebuild = (options.flags & TOLIMAN_TRACK_REBUILD) != 0;
    track::Orbit orbit;
    static_cast<track::Setup &>(plan) = track::setup_of(request, source, plan.terms, place, orbit);
    plan.columns = track::columns_of(options.estimator.values, source, plan.reference.is_given());
    plan.retry = retry_of(options, plan.terms);
    plan.reduce = std::move(orbit.reduce);
    if (options.estimator.estimate != nullptr)
        source.estimate = estimate_of(options, plan.terms, plan.columns);
    if (options.estimator.fit != nullptr)
        source.estimate = moving_source(options, plan.grid.time_offset_ns).estimate;
    auto made = std::unique_ptr<toliman_track>(
        new toliman_track{{}, {{}, period::Stream(plan.grid)}, std::nullopt, options.estimator, options.reduction.sky});
    made->tracker.emplace(std::move(plan), std::move(source.estimate), std::move(place), made->period.stream);
    keep_options(*made, options);
    return made;
}

using Frames = StructArray<const toliman_frame>;
using Outcomes = StructArray<toliman_track_outcome>;

// Networks and templates are made for the scene of one frame.
bool measures_sums(const toliman_track_estimator &estimator) noexcept {
    return estimator.cae == nullptr && estimator.linear == nullptr && estimator.bank == nullptr;
}

// Processes `count` checked frames from index `done`, and adds the number processed to `done`, also on failure.
void push_batch(track::Tracker &tracker, const Frames &frames, size_t count, const Outcomes &outcomes, size_t &done) {
    track::Frame batch[track::Tracker::kBatch];
    track::Outcome results[track::Tracker::kBatch];
    for (size_t i = 0; i < count; i++)
        batch[i] = frame_of(frames.get(done + i));
    size_t processed = 0;
    const auto deliver_outcomes = [&] {
        for (size_t i = 0; i < processed; i++)
            outcomes.put(done + i, public_outcome(results[i]));
        done += processed;
    };
    try {
        tracker.push(batch, count, results, processed);
    } catch (...) {
        deliver_outcomes();
        throw;
    }
    deliver_outcomes();
}

} // namespace

extern "C" {

toliman_status toliman_track_load_options(const char *folder, toliman_track_options *options) noexcept {
    return guard([&] {
        const std::unique_ptr<Store> store = open_folder(&required(folder, "folder"), Access::read);
        if (!track::has_state(*store))
            fail(Status::not_found, "{%s}: has no ledger of frames", folder);
        toliman_track_options made = options_of(*store);
        made.folder = folder;
        deliver(made, options, "options");
    });
}

toliman_status toliman_track_create(const toliman_track_options *options, toliman_track **out) noexcept {
    return guard([&] {
        const toliman_track_options known = known_options(options);
        required(out, "out");
        const MemoryScope scope(memory_of(known.allocator));
        *out = make_track(known).release();
    });
}

void toliman_track_destroy(toliman_track *track) noexcept {
    destroy(track);
}

toliman_status toliman_track_push(toliman_track *track, const toliman_frame *frames, size_t count,
                                  toliman_track_outcome *outcomes, size_t *done) noexcept {
    return guard([&] {
        const ExclusiveUse use(track);
        track::Tracker &tracker = *use->tracker;
        const EstimatorUse estimator(use->estimator, use->sky);
        required(done, "done") = 0;
        if (count == 0)
            return;
        const Frames given(frames, "frames");
        const Outcomes results(outcomes, "outcomes");
        for (size_t i = 0; i < count; i++) {
            const toliman_frame frame = given.get(i);
            if (frame.struct_size != given.size())
                fail(Status::argument, "{frames[%zu].struct_size} = %u: must be %u, as in frames[0]", i,
                     frame.struct_size, given.size());
            check_frame(frame, i, tracker.plan().terms);
            if (frame.spread != nullptr && !measures_sums(use->estimator))
                fail(Status::unsupported, "{frames[%zu].spread}: must be NULL: only a fit measures sums of frames", i);
        }
        while (*done < count)
            push_batch(tracker, given, std::min(track::Tracker::kBatch, count - *done), results, *done);
    });
}

toliman_status toliman_track_commit(toliman_track *track) noexcept {
    return guard([&] { Use(track, "track")->tracker->commit(); });
}

toliman_status toliman_track_save(toliman_track *track) noexcept {
    return guard([&] { Use(track, "track")->tracker->save(); });
}

toliman_status toliman_track_merge(toliman_track *track, const char *folder, uint32_t flags, int64_t *lost) noexcept {
    return guard([&] {
        const ExclusiveUse use(track);
        if ((flags & ~TOLIMAN_TRACK_SALVAGE) != 0)
            fail(Status::argument, "{flags} = 0x%x: must be 0 or TOLIMAN_TRACK_SALVAGE", flags);
        const std::unique_ptr<Store> other = open_folder(&required(folder, "folder"), Access::read);
        const uint64_t lines = use->tracker->merge(*other, flags != 0);
        if (lost != nullptr)
            *lost = static_cast<int64_t>(lines);
    });
}

} // extern "C"
