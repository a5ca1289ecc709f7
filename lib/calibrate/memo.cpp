// Method: a calibration is a function of its inputs, and nearly all of its time is spent in five functions. Their
// results are appended to a journal as they are computed. After an interruption the same steps are taken again with the
// recalled results, which takes milliseconds, up to the first that is missing: damping, phase and choices of the
// calibration need no state of their own, and the bits are those of an undisturbed one. Each result has as key a hash
// of what it was computed from. Where the steps differ from those of the earlier process, as with more iterations, no
// key fits, and the rest of the journal is dropped. Long functions keep parts of their result in the same way: blocks
// of some frames, products of the conjugate gradients. The parts are replaced by the result once it is complete.
// Derivative images are not kept: 400 MB take a disk longer than the processor. Rejected: to save the parameters, and
// to start there. Damping, derivatives and the stage of the work then differ, and the result with them.
#include "calibrate/memo.hpp"

#include <cstring>

#include "base/hash.hpp"
#include "calibrate/map.hpp"
#include "calibrate/response.hpp"
#include "calibrate/solve.hpp"
#include "sky/prediction.hpp"

namespace toliman::calibrate {

namespace {

// A failure of the machine costs the results of this time, and the one it interrupts: a sync may take longer than a
// small result.
constexpr auto kDurableEvery = std::chrono::seconds(1);

uint64_t hash_of(double value, uint64_t hash) noexcept {
    return fnv1a(with_bits<uint64_t>(value), hash);
}

uint64_t hash_of(const std::vector<Free> &free) noexcept {
    uint64_t hash = kFnvOffset;
    for (const Free &one : free)
        hash = hash_of(one.sigma, fnv1a(static_cast<uint64_t>(one.parameter.number),
                                        fnv1a(static_cast<uint64_t>(one.parameter.kind), hash)));
    return hash;
}

uint64_t hash_of(const Frames &frames, size_t pixels) {
    uint64_t hash = kFnvOffset;
    Buffer<double> counts(pixels);
    for (size_t k = 0; k < frames.count; k++) {
        frames.read(k, counts.data());
        hash = fnv1a(counts, hash);
        const fit::Prediction &prediction = frames.predictions[k];
        hash = fnv1a(std::array<double, 5>{prediction.days, prediction.shift_px[0], prediction.shift_px[1],
                                           prediction.separation_px, prediction.position_angle_deg},
                     hash);
        const Spread &spread = prediction.spread;
        if (spread.any())
            hash = fnv1a(spread.cumulants,
                         fnv1a(std::array<double, 4>{spread.frames, spread.xx, spread.yy, spread.xy}, hash));
    }
    return hash;
}

// Text and files.
uint64_t hash_of(const Scene &scene, const optics::Outline &nominal) noexcept {
    uint64_t hash = fnv1a(scene.digest, kFnvOffset);
    if (scene.binary.sky != nullptr)
        hash = fnv1a(scene.binary.sky->digest(), hash);
    for (const sky::Interval &window : scene.cadence.windows)
        hash = fnv1a(std::array<int64_t, 2>{window.start_ns, window.end_ns}, hash);
    hash = fnv1a(scene.cadence.times_days, fnv1a(scene.detector.bad_pixels, hash));
    hash = fnv1a(scene.detector.response, hash);
    hash = fnv1a(nominal.pupil.opd_m, fnv1a(nominal.pupil.amplitude, hash));
    for (const std::vector<double> &photons : nominal.light.photons)
        hash = fnv1a(photons, hash);
    return fnv1a(nominal.light.qe, fnv1a(nominal.light.wavelength_m, hash));
}

// Writes results, and reads them with the same functions. Reading past the end is Status::format. Arrays are copied, as
// images are large: a journal is of one machine, and little-endian as all for which the library is built.
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
struct Writer {
    ByteWriter bytes;
    void number(double &value) { bytes.f64(value); }
    void numbers(double *values, size_t count) { bytes.raw(values, count * sizeof *values); }
    void size(size_t &value) { bytes.u64(value); }
    void flag(bool &value) { bytes.u8(value ? 1 : 0); }
    template <class List> void length(List &list, size_t) { bytes.u64(list.size()); }
    void expect(size_t) {}
};
struct Reader {
    ByteReader bytes;
    void number(double &value) { value = bytes.f64(); }
    void numbers(double *values, size_t count) {
        if (count > 0)
            std::memcpy(values, bytes.raw(count * sizeof *values), count * sizeof *values);
    }
    void size(size_t &value) { value = static_cast<size_t>(bytes.u64()); }
    void flag(bool &value) { value = bytes.u8() != 0; }
    // least: bytes of an element
    template <class List> void length(List &list, size_t least) {
        const uint64_t count = bytes.u64();
        if (count > bytes.left() / least)
            fail(Status::format, "journal: truncated");
        list.resize(static_cast<size_t>(count));
    }
    // That many numbers follow, for which memory is needed.
    void expect(size_t count) {
        if (count > bytes.left() / 8)
            fail(Status::format, "journal: truncated");
    }
};

template <class Stream> void pass(Stream &stream, double &value) {
    stream.number(value);
}

template <class Stream, class List> void pass_numbers(Stream &stream, List &list) {
    stream.length(list, 8);
    stream.numbers(list.data(), list.size());
}

template <class Stream> void pass(Stream &stream, OwnOfFrames &own) {
    stream.length(own, kOwn * sizeof(double));
    for (auto &frame : own)
        for (double &value : frame)
            stream.number(value);
}

template <class Stream> void pass(Stream &stream, BadPixels &bad) {
    size_t count = bad.count();
    stream.size(count);
    BadPixels passed;
    for (size_t i = 0; i < count; i++) {
        size_t pixel = i < bad.count() ? bad[i] : 0;
        stream.size(pixel);
        if (!passed.add(pixel))
            fail(Status::format, "journal: %zu bad pixels of a frame", count);
    }
    bad = passed;
}

template <class Stream> void pass(Stream &stream, std::vector<BadPixels> &frames) {
    stream.length(frames, 8);
    for (BadPixels &bad : frames)
        pass(stream, bad);
}

template <class Stream> void pass(Stream &stream, Point &point) {
    stream.length(point.instrument, 8);
    for (std::vector<double> &window : point.instrument)
        pass_numbers(stream, window);
    pass(stream, point.own);
    pass_numbers(stream, point.map_m);
    pass_numbers(stream, point.response);
    pass(stream, point.bad);
}

// The matrix is symmetric.
template <class Stream> void pass(Stream &stream, Block &block) {
    pass_numbers(stream, block.gradient);
    const size_t size = block.gradient.size();
    stream.expect(size * (size + 1) / 2);
    block.matrix.resize(size * size);
    for (size_t i = 0; i < size; i++)
        for (size_t j = i; j < size; j++) {
            stream.number(block.matrix[i * size + j]);
            block.matrix[j * size + i] = block.matrix[i * size + j];
        }
    stream.number(block.chi_square);
    stream.number(block.inverse_counts);
    stream.size(block.used);
    stream.size(block.saturated);
}

template <class Stream> void pass(Stream &stream, std::vector<Block> &blocks) {
    stream.length(blocks, 5 * 8);
    for (Block &block : blocks)
        pass(stream, block);
}

template <class Stream> void pass(Stream &stream, Linearisation &normal) {
    pass(stream, normal.blocks);
    for (double *value : {&normal.chi_square, &normal.inverse_counts, &normal.excess})
        stream.number(*value);
    stream.size(normal.used);
    stream.flag(normal.lost);
    stream.flag(normal.refused);
}

template <class Stream> void pass(Stream &stream, Step &step) {
    pass(stream, step.change);
    stream.number(step.largest);
    stream.flag(step.solvable);
}

template <class Stream> void pass(Stream &stream, MapStep &step) {
    pass(stream, step.change);
    for (double *value : {&step.chi_square, &step.residual, &step.rms_m})
        stream.number(*value);
    stream.size(step.used);
    stream.flag(step.lost);
    stream.flag(step.solvable);
}

template <class Stream> void pass(Stream &stream, ResponseStep &step) {
    pass(stream, step.change);
    pass_numbers(stream, step.sigma);
    pass_numbers(stream, step.covariance);
    for (double *value : {&step.separation_sigma_px, &step.chi_square, &step.largest})
        stream.number(*value);
    stream.size(step.used);
    stream.flag(step.lost);
    stream.flag(step.solvable);
}

template <class Stream> void pass(Stream &stream, Buffer<double> &numbers) {
    pass_numbers(stream, numbers);
}

// Of the function, by its result.
constexpr uint64_t kind_of(const OwnOfFrames *) noexcept {
    return 1;
}
constexpr uint64_t kind_of(const Linearisation *) noexcept {
    return 2;
}
constexpr uint64_t kind_of(const Step *) noexcept {
    return 3;
}
constexpr uint64_t kind_of(const MapStep *) noexcept {
    return 4;
}
constexpr uint64_t kind_of(const double *) noexcept {
    return 5;
}
constexpr uint64_t kind_of(const std::vector<Block> *) noexcept {
    return 6;
}
constexpr uint64_t kind_of(const Buffer<double> *) noexcept {
    return 7;
}
constexpr uint64_t kind_of(const ResponseStep *) noexcept {
    return 9;
}
constexpr uint64_t kind_of(const std::vector<BadPixels> *) noexcept {
    return 10;
}

} // namespace

uint64_t hash_of(const Point &point) noexcept {
    uint64_t hash = kFnvOffset;
    for (const std::vector<double> &window : point.instrument)
        hash = fnv1a(window, hash);
    for (const auto &own : point.own)
        hash = fnv1a(own, hash);
    for (const BadPixels &bad : point.bad) {
        hash = fnv1a(uint64_t{bad.count()}, hash);
        for (const size_t pixel : bad)
            hash = fnv1a(uint64_t{pixel}, hash);
    }
    return fnv1a(point.response, fnv1a(point.map_m, hash));
}

std::vector<Journal::Input> inputs_of(const Problem &problem, const optics::Outline &nominal, const Point &start) {
    uint64_t options = hash_of(problem.smoothness, hash_of(problem.capture_px, kFnvOffset));
    for (const Window &window : problem.windows)
        options = fnv1a(window.shares, hash_of(window.first_days, options));
    const Detector &detector = problem.nominal.detector;
    return {{"another scene", hash_of(problem.nominal, nominal)},
            {"other frames", hash_of(problem.frames, detector.rows * detector.cols)},
            {"other free parameters", hash_of(problem.free)},
            {"other windows, smoothness or capture", options},
            {"another start", hash_of(start)}};
}

void Memo::begin(const Problem &problem, uint32_t improved) noexcept {
    model_ = fnv1a(
        uint64_t{problem.windows.size()},
        fnv1a(uint64_t{improved}, fnv1a(uint64_t{problem.nominal.telescope.pupil_samples}, hash_of(problem.free))));
}

template <class Result> uint64_t Memo::key_of(std::initializer_list<uint64_t> what, const Result *kind) const noexcept {
    uint64_t hash = fnv1a(kind_of(kind), model_);
    for (const uint64_t number : what)
        hash = fnv1a(number, hash);
    return hash;
}

template <class Result> bool Memo::take(uint64_t key, Result &result) {
    const Journal::Record *const next = journal_.next();
    if (next == nullptr || next->key != key)
        return false;
    Reader reader = {ByteReader(next->bytes.data(), next->bytes.size(), "journal")};
    try {
        pass(reader, result);
    } catch (const Error &error) {
        if (error.status() != Status::format)
            throw;
        return false;
    }
    if (reader.bytes.left() > 0)
        return false;
    journal_.take();
    return true;
}

template <class Result> void Memo::append(uint64_t key, const Result &result) {
    Writer writer;
    pass(writer, const_cast<Result &>(result)); // only read
    const auto now = std::chrono::steady_clock::now();
    const bool durable = depth_ == 0 && now - durable_ >= kDurableEvery;
    journal_.append(key, writer.bytes.take(), durable);
    if (durable)
        durable_ = now;
}

#define TOLIMAN_MEMO(...)                                                                                              \
    template uint64_t Memo::key_of(std::initializer_list<uint64_t>, const __VA_ARGS__ *) const noexcept;               \
    template bool Memo::take(uint64_t, __VA_ARGS__ &);                                                                 \
    template void Memo::append(uint64_t, const __VA_ARGS__ &);
TOLIMAN_MEMO(OwnOfFrames)
TOLIMAN_MEMO(Linearisation)
TOLIMAN_MEMO(Step)
TOLIMAN_MEMO(MapStep)
TOLIMAN_MEMO(ResponseStep)
TOLIMAN_MEMO(double)
TOLIMAN_MEMO(std::vector<Block>)
TOLIMAN_MEMO(std::vector<BadPixels>)
TOLIMAN_MEMO(Buffer<double>)
#undef TOLIMAN_MEMO

} // namespace toliman::calibrate
