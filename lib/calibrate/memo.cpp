// Method: a calibration is a function of its inputs, and nearly all of its time is spent in five functions. Their results
// are appended to a journal as they are computed. After an interruption the same steps are taken again with the recalled
// results, which takes milliseconds, up to the first that is missing: damping, phase and choices of the calibration need no
// state of their own, and the bits are those of an undisturbed one. Each result has as key a hash of what it was computed
// from. Where the steps differ from those of the earlier process, as with more iterations, no key fits, and the rest of
// the journal is dropped.
// Rejected: to save the parameters, and to start there. Damping, derivatives and the stage of the work then differ, and the
// result with them.
#include "calibrate/memo.hpp"

#include "base/bytes.hpp"
#include "base/hash.hpp"
#include "sky/prediction.hpp"

namespace toliman::calibrate {

namespace {

uint64_t hash_of(double value, uint64_t hash) noexcept {
    return fnv1a(with_bits<uint64_t>(value), hash);
}

uint64_t hash_of(const Point &point, uint64_t hash) noexcept {
    for (const std::vector<double> &window : point.instrument)
        hash = fnv1a(window, hash);
    for (const auto &own : point.own)
        hash = fnv1a(own, hash);
    return fnv1a(point.map_m, hash);
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
    }
    return hash;
}

// Text and files.
uint64_t hash_of(const Scene &scene, const optics::Outline &nominal) noexcept {
    uint64_t hash = fnv1a(scene.digest, kFnvOffset);
    if (scene.binary.sky != nullptr)
        hash = fnv1a(scene.binary.sky->digest(), hash);
    hash = fnv1a(scene.detector.bad_pixels, hash);
    hash = fnv1a(nominal.pupil.opd_m, fnv1a(nominal.pupil.amplitude, hash));
    for (const std::vector<double> &photons : nominal.light.photons)
        hash = fnv1a(photons, hash);
    return fnv1a(nominal.light.wavelength_m, hash);
}

// Writes results, and reads them with the same functions. Reading past the end is Status::format.
struct Writer {
    ByteWriter bytes;
    void number(double &value) { bytes.f64(value); }
    void size(size_t &value) { bytes.u64(value); }
    void flag(bool &value) { bytes.u8(value ? 1 : 0); }
    template <class List> void length(List &list, size_t) { bytes.u64(list.size()); }
};
struct Reader {
    ByteReader bytes;
    void number(double &value) { value = bytes.f64(); }
    void size(size_t &value) { value = static_cast<size_t>(bytes.u64()); }
    void flag(bool &value) { value = bytes.u8() != 0; }
    // least: bytes of an element
    template <class List> void length(List &list, size_t least) {
        const uint64_t count = bytes.u64();
        if (count > bytes.left() / least)
            fail(Status::format, "journal: truncated");
        list.resize(static_cast<size_t>(count));
    }
};

template <class Stream> void pass(Stream &stream, double &value) {
    stream.number(value);
}

template <class Stream, class List> void pass_numbers(Stream &stream, List &list) {
    stream.length(list, 8);
    for (double &value : list)
        stream.number(value);
}

template <class Stream> void pass(Stream &stream, Own &own) {
    stream.length(own, kOwn * sizeof(double));
    for (auto &frame : own)
        for (double &value : frame)
            stream.number(value);
}

template <class Stream> void pass(Stream &stream, Point &point) {
    stream.length(point.instrument, 8);
    for (std::vector<double> &window : point.instrument)
        pass_numbers(stream, window);
    pass(stream, point.own);
    pass_numbers(stream, point.map_m);
}

// The matrix is symmetric.
template <class Stream> void pass(Stream &stream, Block &block) {
    pass_numbers(stream, block.gradient);
    const size_t size = block.gradient.size();
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

template <class Stream> void pass(Stream &stream, Linearised &result) {
    Linearisation &normal = result.normal;
    stream.length(normal.blocks, 8);
    for (Block &block : normal.blocks)
        pass(stream, block);
    for (double *value : {&normal.chi_square, &normal.inverse_counts, &normal.excess})
        stream.number(*value);
    stream.size(normal.used);
    stream.flag(normal.lost);
    stream.flag(result.refused);
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

// Of the function, by its result.
constexpr uint64_t kind_of(const Own *) noexcept { return 1; }
constexpr uint64_t kind_of(const Linearised *) noexcept { return 2; }
constexpr uint64_t kind_of(const Step *) noexcept { return 3; }
constexpr uint64_t kind_of(const MapStep *) noexcept { return 4; }
constexpr uint64_t kind_of(const double *) noexcept { return 5; }

} // namespace

std::vector<Journal::Input> inputs_of(const Problem &problem, const optics::Outline &nominal, const Point &start) {
    uint64_t options = hash_of(problem.smoothness, hash_of(problem.capture_px, kFnvOffset));
    for (const Window &window : problem.windows)
        options = hash_of(window.first_days, options);
    const Detector &detector = problem.nominal.detector;
    return {{"another scene", hash_of(problem.nominal, nominal)},
            {"other frames", hash_of(problem.frames, detector.rows * detector.cols)},
            {"other free parameters", hash_of(problem.free)},
            {"other windows, smoothness or capture", options},
            {"another start", hash_of(start, kFnvOffset)}};
}

void Memo::begin(const Problem &problem, uint32_t improved) noexcept {
    model_ = fnv1a(uint64_t{improved}, fnv1a(uint64_t{problem.nominal.telescope.pupil_samples}, hash_of(problem.free)));
}

template <class Result>
uint64_t Memo::key_of(const Result *kind, const Point &point, std::initializer_list<uint64_t> numbers) const noexcept {
    uint64_t hash = hash_of(point, fnv1a(kind_of(kind), model_));
    for (const uint64_t number : numbers)
        hash = fnv1a(number, hash);
    return hash;
}

template <class Result> bool Memo::read(const std::vector<uint8_t> &bytes, Result &result) {
    Reader reader = {ByteReader(bytes.data(), bytes.size(), "journal")};
    try {
        pass(reader, result);
    } catch (const Error &error) {
        if (error.status() != Status::format)
            throw;
        return false;
    }
    return reader.bytes.left() == 0;
}

template <class Result> std::vector<uint8_t> Memo::bytes_of(const Result &result) {
    Writer writer;
    pass(writer, const_cast<Result &>(result)); // only read
    return writer.bytes.take();
}

#define TOLIMAN_MEMO(Result)                                                                                           \
    template uint64_t Memo::key_of(const Result *, const Point &, std::initializer_list<uint64_t>) const noexcept;       \
    template bool Memo::read(const std::vector<uint8_t> &, Result &);                                                  \
    template std::vector<uint8_t> Memo::bytes_of(const Result &);
TOLIMAN_MEMO(Own)
TOLIMAN_MEMO(Linearised)
TOLIMAN_MEMO(Step)
TOLIMAN_MEMO(MapStep)
TOLIMAN_MEMO(double)
#undef TOLIMAN_MEMO

} // namespace toliman::calibrate
