// A tracker's folder: ledger, setup, checkpoint and names. A folder that opens gives its records and counts, continues,
// and is the same after it is saved and reopened. It can be merged into another one, and its frames can be reduced
// again.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
// promise: parsers-are-safe

#include "memory_store.hpp"
#include "track/tracker.hpp"

using namespace fuzz;
using namespace toliman;

namespace {

constexpr const char *kNames[] = {track::LedgerFile::kName, track::Setup::kName, track::Checkpoint::kName,
                                  track::Names::kName, track::Setup::kNewName};
constexpr size_t kFiles = 5, kNewSetup = 4, kLedger = 0, kSetup = 1, kCheckpoint = 2;
constexpr size_t kState = 4 + 4 + 8 + 8 + 8 + 4 + 4; // offset of the state in a checkpoint
constexpr int64_t kMostFrequencies = 64, kCapacity = 64;
constexpr size_t kMostPixels = 64, kPixels = 16;
using Parts = std::array<Bytes, kFiles>;

// An input holds the sizes of the files, u16 each and 0 for a missing file, followed by the files.
Parts parts_of(const uint8_t *data, size_t size) {
    Source source(data, size);
    Parts parts;
    size_t sizes[kFiles];
    for (size_t &part : sizes)
        part = source.number(2);
    for (size_t i = 0; i < kFiles; i++)
        parts[i] = source.bytes(sizes[i]);
    return parts;
}

Bytes input_of(const Parts &parts) {
    Bytes input(2 * kFiles);
    for (size_t i = 0; i < kFiles; i++)
        put(input, 2 * i, parts[i].size(), 2);
    for (const Bytes &part : parts)
        input.insert(input.end(), part.begin(), part.end());
    return input;
}

Files files_of(const Parts &parts) {
    Files files;
    for (size_t i = 0; i < kFiles; i++)
        if (!parts[i].empty())
            files[kNames[i]] = parts[i];
    return files;
}

// The parameters with which a folder was created.
struct Made {
    track::Terms terms;
    std::string further; // names of the values
    track::Timing timing;
    track::Reference reference;
    bool rebuild = false;
};

// A tracker and its periodogram, on files.
struct Run {
    Run(Files &files, Access access, const Made &made) : Run(place_of(files, access, made), made) {}
    explicit Run(const Made &made) : Run(track::StateFolder(), made) {} // in memory

    void push(int64_t id) { push_pixel(id, 1); }
    // Pushes a frame whose first pixel is its value.
    void push_pixel(int64_t id, uint16_t pixel) {
        const double on_target[] = {0, 0.25, 0.5, 1};
        const uint16_t pixels[kPixels] = {pixel, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
        const track::Frame frame = {"s",        "r", id, id * 1000, 0,         pixels, 4, 4, 4,
                                    Pixel::u16, 0,   0,  1,         on_target, 2,      3, 4};
        track::Outcome outcome;
        size_t done;
        tracker->push(&frame, 1, &outcome, done);
    }

    period::Stream sums;
    std::optional<track::Tracker> tracker;

  private:
    static track::StateFolder place_of(Files &files, Access access, const Made &made) {
        track::StateFolder place = track::open_state_folder(std::make_unique<MemoryStore>(files), access, made.terms);
        place.rebuild = made.rebuild;
        return place;
    }
    // By its length only, as the intervals of a ledger may be any numbers.
    static track::Reason reduce(const track::OnTarget &on_target, track::Reduction &reduction) {
        reduction.factor = 1 + 1e-3 * static_cast<double>(on_target.spans.size());
        reduction.geometric_arcsec = 0.25;
        return on_target.spans.front().start_ns % 3000 == 0 ? track::Reason::no_orbit : track::Reason::none;
    }
    static period::Grid grid_of(const track::StateFolder &place, const track::Terms &terms) {
        if (place.setup && place.setup->grid.nf <= kMostFrequencies)
            return place.setup->grid;
        period::Grid grid;
        grid.f0 = 0.01;
        grid.df = 0.01;
        grid.nf = 3;
        grid = track::for_terms(grid, terms);
        grid.check();
        return grid;
    }
    Run(track::StateFolder place, const Made &made) : sums(grid_of(place, made.terms)) {
        track::Plan plan;
        plan.capacity = kCapacity;
        plan.terms = made.terms;
        plan.columns = track::Columns(made.further, made.reference.is_given());
        plan.timing = made.timing;
        plan.reference = made.reference;
        if (made.reference.is_given())
            plan.reduce = reduce;
        if (place.setup)
            plan.clock = place.setup->clock;
        tracker.emplace(
            std::move(plan),
            [](const double *image, const track::Frame &, int64_t, unsigned, track::Estimated &estimated) {
                estimated.value = image[0];
                estimated.chi_square = 1;
                estimated.further.fill(image[1]);
            },
            std::move(place), sums);
    }
};

// Empty if an API call would refuse the ledger.
std::optional<Made> made_of(Files &files) {
    MemoryStore store(files);
    const track::LedgerFile ledger(store);
    const track::Terms terms = ledger.terms();
    terms.check();
    const track::Geometry &geometry = terms.geometry;
    if (geometry.out_rows > kMostPixels || geometry.out_cols > kMostPixels)
        return std::nullopt; // larger images would only be slower
    const std::string further = ledger.columns().further();
    track::Columns expected(further);
    const std::optional<track::Setup> setup = track::load_setup(store);
    return Made{terms, further, setup ? setup->timing : track::Timing(), setup ? setup->reference : track::Reference()};
}

void check(const track::Tracker &tracker) {
    const track::Counts &counts = tracker.counts();
    int64_t sum = counts.accepted + counts.unreduced + counts.outlier + counts.quarantined + counts.repeated;
    for (const int64_t rejected : counts.rejected)
        sum += rejected;
    require(counts.received == sum, "received is not the sum of the verdicts");
    uint64_t lines = 0;
    tracker.visit(0, tracker.records(), [&](const track::Record &record, const track::Outcome &outcome) {
        require(std::isfinite(record.value) && std::isfinite(outcome.value), "a value that is not finite");
        lines++;
    });
    require(lines == tracker.records(), "records are missing");
    for (const double value : tracker.series().y)
        require(std::isfinite(value), "a value that is not finite in the series");
    for (const track::NamedStream &stream : tracker.streams())
        require(stream.name.session.size() <= 64 && stream.count.frames > 0, "an impossible stream");
}

// Reading must change nothing, and what is pushed after reopening must be kept.
void reopen(Files files, const Made &made) {
    const Files before = files;
    check(*Run(files, Access::read, made).tracker);
    require(files == before, "reading has changed a file");
    std::vector<uint8_t> sums;
    uint64_t lines;
    {
        Run run(files, Access::write, made);
        run.push(1);
        run.push(int64_t{1} << 40);
        run.tracker->save();
        check(*run.tracker);
        sums = run.sums.save();
        lines = run.tracker->records();
    }
    const Files saved = files;
    Run again(files, Access::write, made);
    require(again.tracker->records() == lines && again.sums.save() == sums, "reopened with different contents");
    again.tracker->save();
    require(files == saved, "saved files differ from the opened ones");
}

// Reduces all frames again: none is lost, and the folder is then as it was made.
void reduce_again(Files files, Made made) {
    const auto frames_of = [](const Run &run) {
        const track::Counts &counts = run.tracker->counts();
        return counts.accepted + counts.unreduced + counts.outlier + counts.quarantined;
    };
    const int64_t frames = frames_of(Run(files, Access::write, made));
    made.reference = {"{}", 0.5};
    made.rebuild = true;
    std::vector<uint8_t> sums;
    {
        const Run run(files, Access::write, made);
        check(*run.tracker);
        require(frames_of(run) == frames, "a rebuild has lost frames");
        sums = run.sums.save();
    }
    const std::optional<Made> found = made_of(files);
    require(found && found->reference == made.reference, "a rebuild has not changed the reference");
    require(Run(files, Access::read, *found).sums.save() == sums, "rebuilt with different contents");
    require(Run(files, Access::write, made).sums.save() == sums, "rebuilt again with different contents");
}

void merge(Files files, const Made &made, bool salvage) {
    MemoryStore other(files);
    Run run(made);
    run.tracker->merge(other, salvage);
    check(*run.tracker);
    const Bytes sums = run.sums.save();
    run.tracker->merge(other, salvage);
    require(run.sums.save() == sums, "merging again has changed the sums");
}

// Runs the work; it may be refused by an Error, but not by an internal or memory error.
template <class Work> void tried(Work work) {
    try {
        work();
    } catch (const Error &error) {
        require(error.status() != Status::internal && error.status() != Status::memory, error.what());
    }
}

size_t columns_in(const Bytes &ledger) {
    constexpr size_t kPlace = 112;
    return ledger.size() > kPlace ? std::min<size_t>(ledger[kPlace], track::kMaxColumns) : 0;
}

constexpr size_t header_size(size_t columns) {
    return 124 + columns * track::Columns::kSavedSize;
}

// Recomputes the checksums; each continues the previous one.
void repair_ledger(Bytes &ledger) {
    const size_t columns = columns_in(ledger), header = header_size(columns), line = track::record_size(columns);
    if (ledger.size() < header)
        return;
    uint32_t chain = zip::crc32(ledger.data(), header - 4);
    put(ledger, header - 4, chain, 4);
    for (size_t at = header; at + line <= ledger.size(); at += line) {
        chain = zip::crc32(ledger.data() + at, line - 4, chain);
        put(ledger, at + line - 4, chain, 4);
    }
}

void repair_checkpoint(Parts &parts) {
    Bytes &point = parts[kCheckpoint];
    const Bytes &ledger = parts[kLedger], &setup = parts[kSetup];
    const size_t columns = columns_in(ledger), header = header_size(columns);
    if (point.size() < kState + 4 || ledger.size() < header || setup.size() < 4)
        return;
    std::memcpy(point.data() + 8, ledger.data() + 8, 8); // the salt
    const uint8_t *lines_at = point.data() + 16;
    const uint64_t lines = take_number(lines_at, 8), end = header + lines * track::record_size(columns);
    if (lines < 1024 && end <= ledger.size())
        std::memcpy(point.data() + 32, ledger.data() + end - 4, 4);
    std::memcpy(point.data() + 36, setup.data() + setup.size() - 4, 4);
    Bytes state(point.begin() + kState, point.end() - 4);
    seal(state);
    std::copy(state.begin(), state.end(), point.begin() + kState);
    seal(point);
}

} // namespace

// Frames of which one is quarantined, one rejected, one an outlier and one a duplicate; before and after a checkpoint.
std::vector<Bytes> fuzz::seeds() {
    track::Terms terms;
    terms.geometry = {4, 4, 0, 0, 4, 4, 1, 12, 0};
    terms.sigma = 0.5;
    terms.value_limit = 100;
    terms.estimator = 5;
    std::vector<Bytes> seeds;
    Files files, timed_files, reduced_files;
    const Made plain = {terms, "dx", {}, {}}, timed = {terms, "dx", {track::Stamp::start, 0.5}, {}},
               reduced = {terms, track::kMeasured, {}, {"{}", 0.5}};
    for (int64_t pass = 0; pass < 6; pass++) {
        Files &own = pass == 3 ? timed_files : pass > 3 ? reduced_files : files;
        Run run(own, Access::write, pass == 3 ? timed : pass > 3 ? reduced : plain);
        for (int64_t id = 0; id < 6; id++)
            run.push(2 * pass + id);
        run.push_pixel(1, 2);
        run.push_pixel(20 + pass, 101);
        run.push_pixel(30, 65535);
        if (pass == 2)
            run.tracker->commit();
        else
            run.tracker->save();
        Parts parts;
        for (size_t i = 0; i < kFiles; i++)
            parts[i] = own.count(kNames[i]) != 0 ? own[kNames[i]] : Bytes();
        if (pass == 5) // as after a crash
            std::swap(parts[kSetup], parts[kNewSetup]);
        seeds.push_back(input_of(parts));
    }
    return seeds;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const Files files = files_of(parts_of(data, size));
    tried([&] {
        Files own = files;
        const std::optional<Made> made = made_of(own);
        if (!made)
            return;
        fuzz::accepted++;
        tried([&] { reopen(files, *made); });
        tried([&] { reduce_again(files, *made); });
        tried([&] { merge(files, *made, false); });
        tried([&] { merge(files, *made, true); });
    });
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed) {
    Parts parts = parts_of(data, size);
    mutate(parts[seed % kFiles], most / kFiles);
    if (seed / kFiles % 8 != 0) {
        repair_ledger(parts[kLedger]);
        seal(parts[kSetup]);
        seal(parts[kNewSetup]);
        repair_checkpoint(parts);
    }
    return give(input_of(parts), data, most);
}
