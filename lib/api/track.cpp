// include/toliman/track.h: unwrap, call, convert.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <toliman/track.h>

#include "api/grid_flags.hpp"
#include "api/guard.hpp"
#include "api/handles.hpp"
#include "api/memory.hpp"
#include "api/peak.hpp"
#include "api/pixel_frames.hpp"
#include "api/struct_array.hpp"
#include "api/track_results.hpp"
#include "base/workers.hpp"
#include "track/tracker.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_track : Handle<toliman_track> {
    static constexpr char kType[] = "toliman_track";
    toliman_period period;
    std::optional<track::Tracker> tracker = {};
    uint32_t flags = 0;
    const toliman_cae *cae = nullptr; // the estimator, if it is one of these
    const toliman_linear *linear = nullptr;
};

namespace {

constexpr Choice<track::Sync> kSyncs = {TOLIMAN_TRACK_SYNC_GROUP, TOLIMAN_TRACK_SYNC_NONE, "TOLIMAN_TRACK_SYNC_..."};

// A call that changes the sums, which the caller may be querying as a periodogram.
class Changing {
  public:
    explicit Changing(toliman_track *track) : track_(track, "track"), period_(&track->period, "the tracker's period") {}
    toliman_track *operator->() const noexcept { return track_.operator->(); }
    toliman_track &operator*() const noexcept { return *track_; }

  private:
    Use<toliman_track> track_;
    Use<toliman_period> period_;
};

// Keeps the estimator from being trained or destroyed while frames are estimated.
class EstimatorUse {
  public:
    explicit EstimatorUse(const toliman_track &track) {
        if (track.cae != nullptr)
            cae_.emplace(track.cae, "options->cae");
        if (track.linear != nullptr)
            linear_.emplace(track.linear, "options->linear");
    }

  private:
    std::optional<Use<const toliman_cae>> cae_;
    std::optional<Use<const toliman_linear>> linear_;
};

constexpr int64_t kLargestSide = 65536;
constexpr uint32_t kLargestGroup = 65536;
constexpr double kSigmasToLimit = 1e4;

toliman_track_options default_options() noexcept {
    toliman_track_options options = {};
    options.capacity = 1 << 20;
    options.hole_bytes = 4096;
    options.unit_ns = 86400e9;
    options.threads = 1;
    options.group = 64;
    return options;
}

toliman_track_options known_options(const toliman_track_options *given) {
    required(given, "options");
    const toliman_track_options options = accept(given, default_options(), "options");
    if ((options.flags & ~(TOLIMAN_TRACK_READ_ONLY | TOLIMAN_TRACK_REBUILD)) != 0)
        fail(Status::argument, "{options->flags} = 0x%x: unknown bits", options.flags);
    if (options.clock_points > 0)
        required(options.clock, "options->clock");
    if (options.group < 1 || options.group > kLargestGroup)
        fail(Status::argument, "{options->group} = %u: must be in [1, %u]", options.group, kLargestGroup);
    if (options.capacity < 1 || options.capacity > track::FrameIndex::kMost)
        fail(Status::argument, "{options->capacity} = %lld: must be in [1, 2^28]",
             static_cast<long long>(options.capacity));
    if (options.folder == nullptr && options.flags != 0)
        fail(Status::argument, "{options->folder} is NULL: it is needed for READ_ONLY and REBUILD");
    return options;
}

size_t side(int64_t value, const char *name) {
    if (value < 0 || value > kLargestSide)
        fail(Status::argument, "{options->%s} = %lld: must be in [0, %lld]", name, static_cast<long long>(value),
             static_cast<long long>(kLargestSide));
    return static_cast<size_t>(value);
}

// What makes values of images.
struct Source {
    size_t rows = 0, cols = 0; // of the image; 0: any
    double sigma = 0;
    uint64_t digest = 0;
    track::Estimate estimate;
};

Source source_of(const cae::Network &network, unsigned workers) {
    const cae::Preprocess &preprocess = network.preprocess();
    const auto works = std::make_shared<std::vector<cae::Workspace>>(workers);
    for (cae::Workspace &work : *works)
        work.scratch.reserve(cae::kPixels);
    const size_t rows = preprocess.rows, cols = preprocess.cols;
    return {rows, cols, preprocess.crb_px, network.digest(), [=, &network](double *image, unsigned worker) {
                return network.encode({image, rows, cols, cols}, (*works)[worker]);
            }};
}

Source source_of(const linear::TemplateEstimator &estimator) {
    const size_t rows = estimator.rows(), cols = estimator.cols();
    return {rows, cols, estimator.sigma_px(), estimator.digest(), [=, &estimator](double *image, unsigned) {
                return estimator.estimate({image, rows, cols, cols}, image);
            }};
}

Source source_of(const toliman_track_options &options, unsigned workers) {
    const bool given[] = {options.cae != nullptr, options.linear != nullptr, options.estimate != nullptr};
    if (given[0] + given[1] + given[2] > 1)
        fail(Status::argument, "{options}: more than one of cae, linear and estimate");
    if (given[0])
        return source_of(options.cae->network, workers);
    if (given[1])
        return source_of(options.linear->estimator);
    Source source;
    source.digest = options.estimator_id;
    return source;
}

// One side of the geometry from what is given of it.
void complete(size_t &frame, size_t crop, size_t bin, size_t &image, size_t own, const char *name) {
    if (image == 0)
        image = own > 0 ? own : (frame > crop ? (frame - crop) / bin : 0);
    if (own > 0 && image != own)
        fail(Status::argument, "{options->image_%s} = %zu: the estimator takes %zu", name, image, own);
    if (frame == 0)
        frame = crop + image * bin;
    if (image == 0)
        fail(Status::argument, "{options->%s} = %zu, crop %zu, bin = %zu: nothing is left for the estimator", name,
             frame, crop, bin);
}

track::Geometry geometry_of(const toliman_track_options &options, const Source &source) {
    track::Geometry geometry = {};
    geometry.rows = side(options.rows, "rows");
    geometry.cols = side(options.cols, "cols");
    geometry.crop_row = side(options.crop_row, "crop_row");
    geometry.crop_col = side(options.crop_col, "crop_col");
    geometry.out_rows = side(options.image_rows, "image_rows");
    geometry.out_cols = side(options.image_cols, "image_cols");
    geometry.bin = std::max<size_t>(1, side(options.bin, "bin"));
    geometry.bit_depth = options.bit_depth;
    geometry.hole = options.hole_bytes;
    complete(geometry.rows, geometry.crop_row, geometry.bin, geometry.out_rows, source.rows, "rows");
    complete(geometry.cols, geometry.crop_col, geometry.bin, geometry.out_cols, source.cols, "cols");
    return geometry;
}

// The callback, which must know the image's shape.
track::Estimate estimate_of(const toliman_track_options &options, const track::Geometry &geometry) {
    return [call = options.estimate, data = options.estimate_data, rows = geometry.out_rows,
            cols = geometry.out_cols](double *image, unsigned) {
        double value = NAN;
        return call(image, rows, cols, &value, data) == 0 ? value : NAN;
    };
}

track::Terms terms_of(const toliman_track_options &options, const Source &source) {
    track::Terms terms;
    terms.geometry = geometry_of(options, source);
    terms.sigma = options.sigma != 0 ? options.sigma : source.sigma;
    if (terms.sigma == 0)
        fail(Status::argument, "{options->sigma} = 0: the estimator does not know it");
    terms.value_limit = options.value_limit != 0 ? options.value_limit : kSigmasToLimit * terms.sigma;
    terms.estimator = source.digest;
    terms.check();
    return terms;
}

// nf = 0: none.
std::optional<period::Grid> grid_of(const toliman_track_options &options, const track::Terms &terms) {
    if (options.nf == 0)
        return std::nullopt;
    period::Grid grid;
    grid.f0 = options.f0;
    grid.df = options.df;
    grid.nf = options.nf;
    set_flags(grid, options.period_flags, "period_flags");
    grid.time_offset_ns = options.time_offset_ns;
    grid.unit_ns = options.unit_ns;
    grid = track::for_terms(grid, terms);
    grid.check();
    return grid;
}

// No points: none.
std::optional<track::Clock> clock_of(const toliman_track_options &options) {
    if (options.clock_points == 0)
        return std::nullopt;
    std::vector<track::ClockPoint> points(options.clock_points);
    for (size_t i = 0; i < points.size(); i++)
        points[i] = {options.clock[2 * i], options.clock[2 * i + 1]};
    return track::Clock(std::move(points));
}

// What is asked for, and else what the folder has. Of frames that are there neither grid nor clock is guessed.
track::Setup setup_of(std::optional<period::Grid> grid, std::optional<track::Clock> clock, const track::Place &place) {
    const int64_t ledger = place.store ? place.store->size(track::LedgerFile::kName) : -1;
    if (place.setup && (ledger >= 0 || !grid)) {
        grid = grid.value_or(place.setup->grid);
        clock = clock.value_or(place.setup->clock);
    }
    const std::string path = place.store ? place.store->path(track::Setup::kName) : "";
    if (!grid && place.store)
        fail(Status::argument, "{options->nf} = 0: %s, which would have the grid, is missing or damaged", path.c_str());
    if (!grid)
        fail(Status::argument, "{options->nf} = 0: must be at least 1");
    if (!clock && ledger > static_cast<int64_t>(track::LedgerFile::kHeaderSize))
        fail(Status::argument,
             "{options->clock} is NULL: %s, which had the clock, is missing or damaged: give the clock, or the pair 0, "
             "0 "
             "where the camera's time is TAI",
             path.c_str());
    return {*grid, clock.value_or(track::Clock())};
}

std::unique_ptr<toliman_track> make_track(const toliman_track_options &options) {
    track::Plan plan;
    plan.capacity = options.capacity;
    plan.workers = worker_count(options.threads);
    plan.group = options.group;
    plan.sync = kSyncs.take_or(options.sync, track::Sync::group, "options->sync");
    Source source = source_of(options, plan.workers);
    plan.terms = terms_of(options, source);
    if (options.estimate != nullptr)
        source.estimate = estimate_of(options, plan.terms.geometry);

    const std::optional<period::Grid> grid = grid_of(options, plan.terms);
    const std::optional<track::Clock> clock = clock_of(options);
    track::Place place;
    const Access access = (options.flags & TOLIMAN_TRACK_READ_ONLY) != 0 ? Access::read : Access::write;
    if (options.folder != nullptr) // nothing is made there before everything else is known to be right
        place = track::open_place(open_folder(options.folder, access), access, plan.terms);
    place.log = {options.log, options.log_data};
    place.rebuild = (options.flags & TOLIMAN_TRACK_REBUILD) != 0;
    const track::Setup setup = setup_of(grid, clock, place);
    plan.clock = setup.clock;
    auto made = std::unique_ptr<toliman_track>(new toliman_track{
        {}, {{}, period::Stream(setup.grid)}, std::nullopt, options.flags, options.cae, options.linear});
    made->tracker.emplace(std::move(plan), std::move(source.estimate), std::move(place), made->period.stream);
    return made;
}

// A frame that fits this tracker's terms, or an error that names what does not.
track::Frame known_frame(const toliman_frame &given, size_t i, const track::Terms &terms) {
    const auto refuse = [i](const char *name, int64_t value, const char *allowed) {
        fail(Status::argument, "{frames[%zu].%s} = %lld: must be %s", i, name, static_cast<long long>(value), allowed);
    };
    track::check_name(&required(given.session, "frames->session"), "session");
    track::check_name(&required(given.roi, "frames->roi"), "roi");
    required(given.pixels, "frames->pixels");
    if (!kPixels.holds(given.pixel))
        refuse("pixel", given.pixel, "one of TOLIMAN_PIXEL_..., 31 to 41");
    if (given.rows < 1 || given.rows > kLargestSide)
        refuse("rows", given.rows, "in [1, 65536]");
    if (given.cols < 1 || given.cols > kLargestSide)
        refuse("cols", given.cols, "in [1, 65536]");
    if (given.stride != 0 && (given.stride < given.cols || given.stride > INT32_MAX))
        refuse("stride", given.stride, "0 or in [cols, 2^31 - 1]");
    if (given.dropped < 0 || given.dropped > UINT16_MAX)
        refuse("dropped", given.dropped, "in [0, 65535]");
    if (given.sigma != 0 && !terms.allows_sigma(given.sigma))
        fail(Status::argument, "{frames[%zu].sigma} = %g: must be 0 or in [%g, %g], 1 to 32 times the tracker's", i,
             given.sigma, terms.sigma, track::Terms::kMostSigmas * terms.sigma);
    const Pixel pixel = kPixels.take(given.pixel, "pixel");
    if (reinterpret_cast<uintptr_t>(given.pixels) % size_of(pixel) != 0)
        fail(Status::argument, "{frames[%zu].pixels}: must be aligned to %zu bytes, the size of a pixel", i,
             size_of(pixel));
    track::Frame frame = {};
    frame.session = given.session;
    frame.roi = given.roi;
    frame.frame_id = given.frame_id;
    frame.camera_ns = given.camera_ns;
    frame.dropped = static_cast<uint16_t>(given.dropped);
    frame.sigma = given.sigma != 0 ? given.sigma : 0; // whatever its sign
    frame.pixel = pixel;
    frame.pixels = given.pixels;
    frame.rows = static_cast<size_t>(given.rows);
    frame.cols = static_cast<size_t>(given.cols);
    frame.stride = static_cast<size_t>(given.stride != 0 ? given.stride : given.cols);
    return frame;
}

using Frames = StructArray<const toliman_frame>;
using Outcomes = StructArray<toliman_track_outcome>;

// Frames from number `done` on, which were checked; adds to it those that are in, also when it fails.
void push_batch(track::Tracker &tracker, const Frames &frames, size_t count, const Outcomes &outcomes, size_t &done) {
    track::Frame batch[track::Tracker::kBatch];
    track::Outcome results[track::Tracker::kBatch];
    for (size_t i = 0; i < count; i++)
        batch[i] = known_frame(frames.get(done + i), done + i, tracker.plan().terms);
    size_t in = 0;
    const auto give = [&] {
        for (size_t i = 0; i < in; i++)
            outcomes.put(done + i, public_outcome(results[i]));
        done += in;
    };
    try {
        tracker.push(batch, count, results, in);
    } catch (...) {
        give();
        throw;
    }
    give();
}

toliman_track_options options_of(Store &store) {
    toliman_track_options options = default_options();
    const std::optional<track::Setup> setup = track::load_setup(store);
    const track::Terms terms = track::LedgerFile(store).terms();
    const track::Geometry &geometry = terms.geometry;
    const int64_t lines = store.size(track::LedgerFile::kName) / int64_t{track::kRecordSize};
    options.capacity = std::min(std::max(options.capacity, 2 * lines), track::FrameIndex::kMost);
    options.estimator_id = terms.estimator;
    options.sigma = terms.sigma;
    options.value_limit = terms.value_limit;
    options.rows = static_cast<int64_t>(geometry.rows);
    options.cols = static_cast<int64_t>(geometry.cols);
    options.crop_row = static_cast<int64_t>(geometry.crop_row);
    options.crop_col = static_cast<int64_t>(geometry.crop_col);
    options.bin = static_cast<int64_t>(geometry.bin);
    options.image_rows = static_cast<int64_t>(geometry.out_rows);
    options.image_cols = static_cast<int64_t>(geometry.out_cols);
    options.bit_depth = geometry.bit_depth;
    options.hole_bytes = static_cast<uint32_t>(geometry.hole);
    if (setup) {
        const period::Grid &grid = setup->grid;
        options.f0 = grid.f0;
        options.df = grid.df;
        options.nf = grid.nf;
        options.time_offset_ns = grid.time_offset_ns;
        options.unit_ns = grid.unit_ns;
        options.period_flags = flags_of(grid);
    }
    return options;
}

} // namespace

extern "C" {

const char *toliman_track_verdict_name(int32_t verdict) noexcept {
    static const char *const names[] = {"accepted", "duplicate", "quarantined", "outlier", "rejected", "merged"};
    const int32_t place = verdict - TOLIMAN_TRACK_VERDICT_ACCEPTED;
    return place >= 0 && verdict <= TOLIMAN_TRACK_VERDICT_MERGED ? names[place] : "?";
}

const char *toliman_track_reason_name(int32_t reason) noexcept {
    static const char *const names[] = {"none", "shape", "over range", "hole", "not finite", "clock", "estimate"};
    return kReasons.holds(reason) ? names[static_cast<size_t>(kReasons.take(reason, "reason"))] : "?";
}

void toliman_track_options_init(toliman_track_options *options, size_t size) noexcept {
    deliver_defaults(default_options(), options, size);
}

toliman_status toliman_track_load_options(const char *folder, toliman_track_options *options) noexcept {
    return guard([&] {
        const std::unique_ptr<Store> store = open_folder(&required(folder, "folder"), Access::read);
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
        const Changing use(track);
        track::Tracker &tracker = *use->tracker;
        const EstimatorUse estimator(*use);
        required(done, "done") = 0;
        if (count == 0)
            return;
        const Frames given(frames, "frames");
        const Outcomes results(outcomes, "outcomes");
        for (size_t i = 0; i < count; i++) {
            const toliman_frame frame = given.get(i);
            if (frame.struct_size != given.size())
                fail(Status::argument, "{frames[%zu].struct_size} = %u: must be %u, as of frames[0]", i,
                     frame.struct_size, given.size());
            known_frame(frame, i, tracker.plan().terms);
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
        const Changing use(track);
        if ((flags & ~TOLIMAN_TRACK_SALVAGE) != 0)
            fail(Status::argument, "{flags} = 0x%x: must be 0 or TOLIMAN_TRACK_SALVAGE", flags);
        const std::unique_ptr<Store> other = open_folder(&required(folder, "folder"), Access::read);
        const uint64_t lines = use->tracker->merge(*other, flags != 0);
        if (lost != nullptr)
            *lost = static_cast<int64_t>(lines);
    });
}

toliman_status toliman_track_get_lines(const toliman_track *track, int64_t first, size_t count,
                                       toliman_track_line *lines, size_t *done) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const track::Tracker &tracker = *use->tracker;
        required(done, "done");
        if (first < 0)
            fail(Status::argument, "{first} = %lld: must be at least 0", static_cast<long long>(first));
        size_t told = 0;
        if (count == 0) {
            *done = 0;
            return;
        }
        const StructArray<toliman_track_line> found(lines, "lines");
        tracker.visit(static_cast<uint64_t>(first), count,
                      [&](const track::Record &record, const track::Outcome &outcome) {
                          found.put(told++, public_line(record, outcome));
                      });
        *done = told;
    });
}

toliman_status toliman_track_get_info(const toliman_track *track, toliman_track_info *out) noexcept {
    return guard([&] {
        const Use use(track, "track");
        deliver(public_info(*use->tracker, use->flags), out, "out");
    });
}

toliman_status toliman_track_get_rejected(const toliman_track *track, int32_t reason, int64_t *frames) noexcept {
    return guard([&] {
        const Use use(track, "track");
        required(frames, "frames");
        *frames = use->tracker->counts().rejected[static_cast<size_t>(kReasons.take(reason, "reason"))];
    });
}

toliman_status toliman_track_get_streams(const toliman_track *track, toliman_track_stream *streams, size_t room,
                                         size_t *count) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const track::Tracker &tracker = *use->tracker;
        required(count, "count");
        if (room > 0) {
            const StructArray<toliman_track_stream> found(streams, "streams");
            if (room < tracker.stream_count())
                fail(Status::capacity, "{room} = %zu: there are %zu sessions and regions", room,
                     tracker.stream_count());
            const std::vector<track::NamedStream> all = tracker.streams();
            for (size_t i = 0; i < all.size(); i++)
                found.put(i, public_stream(all[i]));
        }
        *count = tracker.stream_count();
    });
}

toliman_status toliman_track_get_clock(const toliman_track *track, int64_t *clock, size_t room,
                                       size_t *points) noexcept {
    return guard([&] {
        const Use use(track, "track");
        const std::vector<track::ClockPoint> &known = use->tracker->plan().clock.points();
        required(points, "points");
        if (clock == nullptr && room > 0)
            fail(Status::argument, "{clock} is NULL");
        if (clock != nullptr && room < known.size())
            fail(Status::capacity, "{room} = %zu: the clock has %zu pairs", room, known.size());
        for (size_t i = 0; clock != nullptr && i < known.size(); i++) {
            clock[2 * i] = known[i].camera_ns;
            clock[2 * i + 1] = known[i].tai_ns;
        }
        *points = known.size();
    });
}

toliman_status toliman_track_query_fit(const toliman_track *track, toliman_period_peak *out) noexcept {
    return guard([&] {
        const Use use(track, "track");
        required(out, "out");
        const track::Series series = use->tracker->series();
        const period::Samples samples = {series.t.data(), series.y.data(), series.sigma.data(), series.t.size()};
        const period::Stream &stream = use->period.stream;
        deliver(public_peak(stream, period::fit_peak(stream, samples)), out, "out");
    });
}

toliman_status toliman_track_get_period(const toliman_track *track, const toliman_period **out) noexcept {
    return guard([&] {
        const Use use(track, "track");
        required(out, "out") = &use->period;
    });
}

} // extern "C"
