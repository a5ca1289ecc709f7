// Tests crafted inputs of the library: decompression bombs, giant dimensions, deep and long JSON, ledgers with hash
// collisions, long tables and numbers.
#include <algorithm>
#include <cstring>
#include <optional>
#include <string>

#include <toliman/toliman.hpp>

#include "bounds.hpp"
#include "cae/layout.hpp"
#include "cae/payload.hpp"
#include "calibrate/solve.hpp"
#include "journal_file.hpp"
#include "memory_file.hpp"
#include "memory_store.hpp"
#include "optics/propagate.hpp"
#include "sky/ephemeris.hpp"
#include "track/tracker.hpp"

using namespace bounds;
using namespace fuzz;
using namespace toliman;

namespace {

std::string repeated(const std::string &text, size_t size) {
    std::string all;
    while (all.size() + text.size() <= size)
        all += text;
    return all;
}

void scene(const char *what, const std::string &json) {
    auto plan = toliman::sized<toliman_sim_plan_info>();
    within(what, 0, [&] {
        expect(toliman_sim_plan_json(json.data(), json.size(), nullptr, nullptr, &plan) != TOLIMAN_OK, what);
    });
}

void scenes() {
    constexpr size_t kMost = 256 << 10;
    scene("scene: above 256 KiB", repeated("[", kMiB));
    scene("scene: deep", repeated("[", kMost));
    scene("scene: deep objects", repeated("{\"a\":", kMost));
    scene("scene: many values", "[" + repeated("0,", kMost - 2) + "0]");
    scene("scene: many objects", "[" + repeated("{},", kMost - 3) + "{}]");
    scene("scene: one string", "\"" + repeated("x", kMost - 2) + "\"");
    scene("scene: one long key", "{\"" + repeated("x", kMost - 8) + "\":1}");
    scene("scene: one number", repeated("1", kMost));
    std::string keys = "{";
    for (size_t i = 0; i < 4000; i++)
        keys += (i > 0 ? ",\"" : "\"") + repeated("k", 50) + std::to_string(1000 + i) + "\":1";
    scene("scene: many keys", keys + "}");
    scene("scene: colons", "[" + repeated(":0,", kMost - 3) + "0]");
}

void period_state(const char *what, int64_t nf, size_t size) {
    toliman_period *period = nullptr;
    expect(toliman_period_create(0.1, 0.1, 4000, nullptr, &period) == TOLIMAN_OK, "no periodogram");
    size_t needed = 0;
    expect(toliman_period_save(period, nullptr, 0, &needed) == TOLIMAN_E_CAPACITY, "no size");
    Bytes bytes(needed);
    expect(toliman_period_save(period, bytes.data(), needed, &needed) == TOLIMAN_OK, "no state");
    toliman_period_destroy(period);
    if (size > 0) {
        bytes.resize(size);
        period::Grid grid;
        grid.f0 = grid.df = 0.1;
        grid.nf = nf;
        grid.sigma_ceiling = period::kSingleLimbSigmaRatio;
        const std::vector<uint8_t> header = period::Stream::header(grid);
        std::copy(header.begin(), header.end(), bytes.begin());
        seal(bytes);
    }
    const bool good = size == 0;
    within(what, good ? size_t{4000} * 129 : 0, [&] {
        toliman_period *out = nullptr;
        expect((toliman_period_load(bytes.data(), bytes.size(), nullptr, &out) == TOLIMAN_OK) == good, what);
        toliman_period_destroy(out);
    });
}

// A blob with 32 nuisance planes and optionally a training, with all numbers equal; or with other streams.
Bytes weights_blob(const Bytes *bomb, bool training) {
    std::vector<cae::Block> tensors, thrice, images(36, {cae::kFlight.pixels(), cae::Encoding::float32});
    for (const cae::Tensor &tensor : cae::kFlight.tensors)
        tensors.push_back({tensor.count(), cae::Encoding::float32});
    for (int i = 0; i < 3; i++)
        thrice.insert(thrice.end(), tensors.begin(), tensors.end());
    const auto pack = [](const std::vector<cae::Block> &blocks) {
        size_t count = 0;
        for (const cae::Block &block : blocks)
            count += block.count;
        return cae::pack(Buffer<float>(count, 0.5F), blocks, "test");
    };
    const Bytes weights = bomb != nullptr ? *bomb : pack(tensors), planes = pack(images), state = pack(thrice);
    ByteWriter out;
    out.raw("TLMW", 4);
    out.u32(3);
    out.u64(104 + weights.size() + planes.size() + (training ? 72 + state.size() : 0) + 4);
    out.u32(1);
    out.u32(training ? 9 : 1);
    out.u64(cae::layout_hash(cae::kFlight));
    out.u64(7);
    out.u64(8);
    for (const uint32_t side : {4096u, 4096u, 0u, 0u, 32u})
        out.u32(side);
    out.u32(0);
    out.f64(1);
    out.f64(1);
    out.f64(0.5);
    out.u32(static_cast<uint32_t>(weights.size()));
    out.u32(static_cast<uint32_t>(planes.size()));
    out.raw(weights.data(), weights.size());
    out.raw(planes.data(), planes.size());
    if (training) {
        out.u32(0);
        out.u32(10);
        for (const uint64_t value : {10u, 100u, 0u, 0u})
            out.u64(value);
        out.u32(0);
        out.u32(static_cast<uint32_t>(state.size()));
        for (const double value : {0.1, 0.2, 0.3})
            out.f64(value);
        out.raw(state.data(), state.size());
    }
    out.u32(0);
    Bytes bytes = out.take();
    seal(bytes);
    return bytes;
}

void weights(const char *what, const Bytes &blob, size_t model) {
    within(what, model, [&] {
        toliman_cae *cae = nullptr;
        const toliman_status status = toliman_cae_load(blob.data(), blob.size(), nullptr, &cae);
        expect(status == (model > 0 ? TOLIMAN_OK : TOLIMAN_E_FORMAT), toliman_last_error());
        toliman_cae_destroy(cae);
    });
}

// promise: weights-have-bounded-memory
void blobs() {
    const Bytes zeros(size_t{1} << 28), bomb = zip::deflate(zeros.data(), zeros.size()); // 1000 : 1
    expect(bomb.size() < 300000, "the bomb is too large");
    weights("weights: bomb", weights_blob(&bomb, false), 0);
    // Planes are double, in the network and in its preprocessing; weights and their moments are float.
    const size_t planes = 36 * cae::kFlight.pixels() * sizeof(double),
                 numbers = cae::kFlight.parameters() * sizeof(float);
    weights("weights: 32 nuisance planes", weights_blob(nullptr, false), planes + numbers);
    weights("weights: with a training", weights_blob(nullptr, true), planes + 4 * numbers);
}

// A bank whose header states this number of dates with one network each, and a stream that does not inflate to it.
void bank(const char *what, uint32_t dates, const Bytes &stream, size_t model) {
    ByteWriter out;
    out.raw("TLMB", 4);
    out.u32(1);
    out.u64(96 + dates * 96 + stream.size() + 4);
    out.u32(1);
    out.u32(0);
    for (const uint64_t value : {cae::layout_hash(cae::kFlight), uint64_t{7}, uint64_t{1}})
        out.u64(value);
    for (const double value : {0.0, 1.0, 0.5})
        out.f64(value);
    for (const uint32_t value : {1u, 600u, 4096u, 4096u, dates, static_cast<uint32_t>(stream.size())})
        out.u32(value);
    for (uint32_t i = 0; i < 3 * dates; i++)
        out.f64(0.5);
    for (uint32_t i = 0; i < dates; i++) {
        for (int k = 0; k < 5; k++)
            out.f64(0.5);
        out.u64(0);
        for (int k = 0; k < 3; k++)
            out.f64(0.5);
    }
    out.raw(stream.data(), stream.size());
    out.u32(0);
    Bytes bytes = out.take();
    seal(bytes);
    within(what, model, [&] {
        toliman_bank *made = nullptr;
        expect(toliman_bank_load(bytes.data(), bytes.size(), nullptr, &made) == TOLIMAN_E_FORMAT, what);
        expect(std::strstr(toliman_last_error(), "compressed payload") != nullptr, toliman_last_error());
    });
}

void banks() {
    constexpr size_t kNetworkBytes = 163076;
    const Bytes zeros(64 * kNetworkBytes + 1), bomb = zip::deflate(zeros.data(), zeros.size());
    bank("bank: short stream for 1024 networks", 1024, Bytes(1000), 0);
    bank("bank: bomb", 64, bomb, 64 * kNetworkBytes);
}

track::Terms small_terms() {
    track::Terms terms;
    terms.geometry = {4, 4, 0, 0, 4, 4, 1, 12, 0};
    terms.sigma = 0.5;
    terms.value_limit = 100;
    return terms;
}

constexpr int64_t kCapacity = 1 << 16;
constexpr size_t kTrackModel = kCapacity * 24 + 98305 * 32 + (size_t{1} << 18);

// lines: expected number of records.
void reopen(const char *what, Files &files, uint64_t lines = 0) {
    within(what, kTrackModel, [&] {
        const track::Terms terms = small_terms();
        period::Grid grid;
        grid.f0 = grid.df = 0.01;
        grid.nf = 3;
        grid = track::for_terms(grid, terms);
        period::Stream sums(grid);
        track::Plan plan;
        plan.capacity = kCapacity;
        plan.terms = terms;
        try {
            const track::Tracker tracker(
                std::move(plan), nullptr,
                track::open_state_folder(std::make_unique<MemoryStore>(files), Access::read, terms), sums);
            expect(tracker.records() == lines, what);
        } catch (const Error &error) {
            expect(error.status() != Status::memory && lines == 0, error.what());
        }
    });
}

constexpr auto kColumns = static_cast<size_t>(track::OwnColumn::factor); // of a ledger without a system
constexpr size_t kLine = track::record_size(kColumns);

Files files_with(const std::vector<track::Record> &records) {
    Files files;
    MemoryStore store(files);
    track::LedgerFile::begin(store, small_terms(), track::Columns());
    const track::LedgerFile file(store);
    uint32_t chain = file.start().chain;
    Bytes &bytes = files.at(track::LedgerFile::kName);
    for (const track::Record &record : records) {
        uint8_t line[kLine];
        chain = track::to_bytes(record, kColumns, 0, chain, line);
        bytes.insert(bytes.end(), line, line + kLine);
    }
    return files;
}

uint64_t inverse(uint64_t odd) {
    uint64_t result = odd;
    for (int i = 0; i < 6; i++)
        result *= 2 - odd * result;
    return result;
}

// The stream whose frame 0 has this digest: inverts track/identity.cpp.
uint64_t stream_of_key(uint64_t key) {
    key = (key ^ key >> 33) * inverse(0xff51afd7ed558ccdu);
    key ^= key >> 33;
    for (int byte = 0; byte < 9; byte++)
        key *= inverse(0x100000001b3u);
    return key;
}

void folders() {
    constexpr uint64_t kLines = kMiB / kLine - 2;
    std::vector<track::Record> records(kLines);
    for (uint64_t i = 0; i < kLines; i++) {
        records[i].sigma = 0.5;
        records[i].stream = i * 98305; // collides in the table of sessions
        records[i].frame_id = static_cast<int64_t>(i);
    }
    Files files = files_with(records);
    reopen("ledger: colliding sessions", files, kLines);
    for (uint64_t i = 0; i < kLines; i++) {
        records[i].stream = stream_of_key(i);
        records[i].frame_id = 0;
    }
    expect(track::key_digest(records[5].stream, 0) == 5, "unexpected digest");
    files = files_with(records);
    reopen("ledger: colliding frames", files, kLines);
    for (uint64_t i = 0; i < kLines; i++)
        records[i] = track::to_record({i, 1, 1, 7}, 0.5, track::Columns().empty());
    files = files_with(records);
    reopen("ledger: as many folders merged", files, kLines);
    files = files_with({});
    files[track::LedgerFile::kName].resize(kMiB);
    reopen("ledger: torn lines", files);
    files = files_with({});
    files[track::Names::kName] = bytes_of(repeated("\n", kMiB));
    reopen("names: empty lines", files);
    files = files_with({});
    Bytes setup = bytes_of("TLMS");
    setup.resize(kMiB, 1);
    put(setup, 4, 1, 4);
    put(setup, 8, 60000, 4);
    for (size_t i = 0; i < 60000; i++)
        put(setup, 12 + 16 * i, i, 8), put(setup, 20 + 16 * i, 2 * i, 8);
    seal(setup);
    files[track::Setup::kName] = setup;
    reopen("setup: many points", files);
    period::Grid grid;
    grid.f0 = grid.df = 0.1;
    grid.nf = 1 << 26;
    grid.sigma_ceiling = 32;
    Bytes point = bytes_of("TLMC");
    point.resize(40);
    const std::vector<uint8_t> header = period::Stream::header(grid);
    point.insert(point.end(), header.begin(), header.end());
    point.resize(kMiB);
    put(point, 4, 1, 4);
    seal(point);
    files = files_with({});
    files[track::Checkpoint::kName] = point;
    reopen("checkpoint: 2^26 frequencies", files);
}

void clocks(const char *what, const std::string &text, size_t model) {
    static MemoryFile file;
    file.set(text.data(), text.size());
    size_t points = 0;
    within(what, model, [&] {
        expect(toliman_ingest_read_clock(file.path().c_str(), nullptr, 0, &points, nullptr, nullptr) ==
                   (model > 0 ? TOLIMAN_E_CAPACITY : TOLIMAN_E_FORMAT),
               what);
        expect(toliman_ingest_read_leap_seconds(file.path().c_str(), nullptr, 0, &points, nullptr) == TOLIMAN_E_FORMAT,
               what);
    });
}

void tables() {
    std::string pairs;
    for (int i = 0; pairs.size() < kMiB - 20; i++)
        pairs += std::to_string(i) + "," + std::to_string(i) + "\n";
    clocks("clock: pairs", pairs, kMiB);
    clocks("clock: one line", repeated(",", kMiB), 0);
    clocks("clock: empty lines", repeated("\n", kMiB), 0);
    std::string steps = "#@ 3928521600\n";
    for (int64_t day = 0; steps.size() < kMiB - 20; day++)
        steps += std::to_string((day + 26297) * 86400) + " " + std::to_string(10 + day % 2) + "\n";
    clocks("leap seconds: one per day", steps, 0);
    const std::string number(kMiB, '9');
    int64_t tai_ns = 0;
    within("time: a long number", 0, [&] {
        for (const std::string &text : {number, "0." + number, "1e" + number, "." + std::string(kMiB, '0') + "1"})
            expect(toliman_ingest_parse_time(text.c_str(), TOLIMAN_INGEST_FORMAT_MJD, TOLIMAN_INGEST_SCALE_TAI, nullptr,
                                             0, &tai_ns) == TOLIMAN_E_RANGE,
                   "time: a long number");
    });
}

// A table of on-target windows that is refused, or has this number of them.
void on_target(const char *what, const std::string &text, size_t windows) {
    static MemoryFile file;
    file.set(text.data(), text.size());
    size_t count = 0;
    within(what, windows * 2 * sizeof(int64_t), [&] {
        const toliman_status status =
            toliman_ingest_read_on_target(file.path().c_str(), nullptr, 0, nullptr, 0, &count);
        expect(windows > 0 ? status == TOLIMAN_E_CAPACITY && count == windows : status == TOLIMAN_E_FORMAT, what);
    });
}

void on_target_tables() {
    std::string table = "start_tai_ns,end_tai_ns\n";
    size_t count = 0;
    for (; table.size() < kMiB - 20; count++)
        table += std::to_string(2 * count) + "," + std::to_string(2 * count + 1) + "\n";
    on_target("windows", table, count);
    on_target("windows: one line", repeated(",", kMiB), 0);
    on_target("windows: one long field", "start_utc,end_utc\n" + std::string(kMiB - 20, '9'), 0);
}

// A pair whose side file has this text, read to its end.
void pair(const char *what, const std::string &text, size_t pixel_bytes, toliman_status status, int64_t frames) {
    static MemoryFile side("x_meta.jsonl"), pixels("x_frames.bin");
    side.set(text.data(), text.size());
    pixels.resize(pixel_bytes);
    within(what, text.size(), [&] {
        auto options = sized<toliman_ingest_options>();
        options.pixel = TOLIMAN_PIXEL_U16;
        toliman_ingest *ingest = nullptr;
        expect(toliman_ingest_create(side.path().c_str(), &options, &ingest) == TOLIMAN_OK, what);
        auto frame = sized<toliman_frame>();
        auto event = sized<toliman_ingest_event>();
        toliman_status found = TOLIMAN_OK;
        do
            found = toliman_ingest_next(ingest, &frame, &event);
        while (found == TOLIMAN_OK && event.event != TOLIMAN_INGEST_EVENT_NOTHING);
        auto info = sized<toliman_ingest_info>();
        expect(toliman_ingest_get_info(ingest, &info) == TOLIMAN_OK && found == status && info.frames == frames, what);
        toliman_ingest_destroy(ingest);
    });
}

void pairs() {
    const auto line = [](const std::string &roi, const char *side) {
        return R"({"roi_label": ")" + roi + R"(", "frame_id": 9007199254740993, "timestamp_ns" : 2, "host_time": 3,)" +
               R"( "nframes_dropped": 4, "n_rows": )" + side + R"(, "n_cols": )" + side + R"(, "session_id": "s"})" +
               "\n";
    };
    pair("pair: empty lines", repeated("\n", kMiB), 0, TOLIMAN_OK, 0);
    pair("pair: small objects", repeated("{}\n", kMiB), 0, TOLIMAN_E_FORMAT, 0);
    pair("pair: one line", repeated("[", kMiB), 0, TOLIMAN_OK, 0);
    pair("pair: one object", "{" + repeated("\"a\":1,", kMiB - 1), 0, TOLIMAN_OK, 0);
    const std::string frames = repeated(line("r", "1"), kMiB);
    const auto count = static_cast<size_t>(std::count(frames.begin(), frames.end(), '\n'));
    pair("pair: frames", frames, 2 * count, TOLIMAN_OK, static_cast<int64_t>(count));
    pair("pair: giant frames", repeated(line("r", "65536"), kMiB), 1000, TOLIMAN_OK, 0);
    std::string names;
    for (int i = 0; names.size() < kMiB - 300; i++)
        names += line(std::to_string(1000000 + i) + std::string(57, 'r'), "1");
    const auto named = static_cast<size_t>(std::count(names.begin(), names.end(), '\n'));
    pair("pair: long names, all different", names, 2 * named, TOLIMAN_OK, static_cast<int64_t>(named));
    pair("pair: a region with the name of a key", line("frame_id", "1"), 2, TOLIMAN_OK, 1);
}

// A file of an observer that is refused, or has this number of states.
void ephemeris(const char *what, const std::string &text, size_t states) {
    static MemoryFile file;
    file.set(text.data(), text.size());
    const ingest::LeapSeconds leap_seconds(erfa::leap_seconds().rows);
    within(what, states * (sizeof(int64_t) + sizeof(sky::State)), [&] {
        try {
            const sky::Ephemeris found = sky::read_ephemeris(file.path(), leap_seconds, {});
            expect(found.segments().front().states.size() == states, what);
        } catch (const Error &error) {
            expect(states == 0 && error.status() == Status::format, error.what());
        }
    });
}

void ephemerides() {
    const std::string header = "t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s\n";
    std::string table = header;
    size_t states = 0;
    for (int64_t time = 0; table.size() < kMiB - 20; time += 10 + static_cast<int64_t>(states % 5), states++)
        table += std::to_string(time) + ",1e6,0,0,0,0,0\n";
    ephemeris("ephemeris: states at uneven steps", table, states);
    ephemeris("ephemeris: one line", repeated(",", kMiB), 0);
    ephemeris("ephemeris: one line after the header", header + repeated(",", kMiB - header.size()), 0);
    ephemeris("ephemeris: empty lines", repeated("\n", kMiB), 0);
    ephemeris("ephemeris: long numbers", header + "0," + std::string(kMiB - 100, '1') + ",0,0,0,0,0", 0);
    const std::string message = "CCSDS_OEM_VERS = 2.0\n";
    ephemeris("ephemeris: comments", message + repeated("COMMENT\n", kMiB - message.size()), 0);
    ephemeris("ephemeris: a long keyword", message + std::string(kMiB - 100, 'X') + " = 1\n", 0);
    ephemeris("ephemeris: a long value", message + "ORIGINATOR = " + std::string(kMiB - 100, 'X') + "\n", 0);
    ephemeris("ephemeris: many segments",
              message + "CREATION_DATE = 1\nORIGINATOR = 1\n" + repeated("META_START\nMETA_STOP\n", kMiB - 100), 0);
}

// A record of a journal with this type of result, whose first numbers are lengths, before zeros.
template <class Result> void journal(const char *what, std::initializer_list<uint64_t> lengths) {
    Bytes bytes(kMiB);
    size_t at = 0;
    for (const uint64_t length : lengths)
        put(bytes, 8 * at++, length, 8);
    within(what, 16 * kMiB, [&] { // frames without bad pixels have 32 times the bytes of their record
        write_journal<Result>(bytes);
        expect(!recall<Result>(), what);
    });
    std::filesystem::remove(journal_path());
}

void journals() {
    constexpr uint64_t kNumbers = kMiB / 8 - 2;
    journal<calibrate::Linearisation>("journal: a matrix of 2^34 numbers", {1, kNumbers});
    journal<std::vector<calibrate::Block>>("journal: many blocks", {kNumbers});
    journal<std::vector<BadPixels>>("journal: many frames", {kNumbers});
    journal<calibrate::Step>("journal: many windows", {kNumbers});
}

void series(const char *what, const std::string &text, size_t samples) {
    auto options = toliman::sized<toliman_measure_options>();
    within(what, samples * 64, [&] {
        toliman_measure *measure = nullptr;
        const toliman_status status = toliman_measure_load(text.data(), text.size(), "x", &options, &measure);
        expect((status == TOLIMAN_OK) == (samples > 0), toliman_last_error());
        toliman_measure_destroy(measure);
    });
}

void files_of_series() {
    series("series: short lines", "t,y\n" + repeated("1,2\n", kMiB / 64), kMiB / 256);
    series("series: one line", repeated("1,", kMiB), 0);
    series("series: empty lines", repeated("\n", kMiB), 0);
    series("series: deep JSON", repeated("[", kMiB), 0);
    series("series: many columns", repeated("a,", kMiB - 8) + "t\n1,2\n", 0);
    series("series: comments", repeated("# x\n", kMiB), 0);
}

} // namespace

// promise: resources-are-bounded
int main() {
    scenes();
    period_state("period: 2^26 frequencies in 1 MiB", 1 << 26, kMiB);
    period_state("period: another size", 10, kMiB);
    period_state("period: 4000 frequencies", 4000, 0);
    blobs();
    banks();
    folders();
    tables();
    on_target_tables();
    pairs();
    ephemerides();
    journals();
    files_of_series();
    return failures != 0;
}
