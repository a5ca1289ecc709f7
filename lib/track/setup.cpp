// Method: to reduce all frames again changes two files, ledger and setup. The new setup is written under a new name,
// with the salt of the new ledger. The ledger is then replaced, which is the moment of the change: from there on the
// setup with the new name is in force. It is renamed last.
#include "track/setup.hpp"

#include <cmath>
#include <utility>

#include "track/framing.hpp"
#include "track/ledger_file.hpp"

namespace toliman::track {

namespace {

constexpr char kSetupMagic[] = "TLMS", kSetupKind[] = "setup";
constexpr uint32_t kSetupVersion = 5, kVersionWithoutLimit = 4, kVersionWithoutFunctions = 3,
                   kVersionWithoutReference = 2, kVersionWithoutTiming = 1;
constexpr size_t kLongestSystem = size_t{256} << 10;
constexpr double kMostScale = 1e6;       // arcsec per px
constexpr double kLongestExposure = 1e9; // s
constexpr size_t kPointSize = 16;
constexpr int64_t kLargestSetup = int64_t{1} << 30;

const char *name_of(Stamp stamp) noexcept {
    static const char *const names[] = {"start", "middle", "end"};
    return names[static_cast<size_t>(stamp)];
}

const char *place_of(const Reference &reference) noexcept {
    return reference.in_orbit ? "in orbit" : "at the Earth's centre";
}

Timing read_timing(ByteReader &in) {
    const uint32_t stamp = in.u32();
    const double exposure = in.f64();
    if (stamp > static_cast<uint32_t>(Stamp::end) || !(exposure >= 0 && exposure <= kLongestExposure))
        fail(Status::format, "%s: time stamps %u of exposures of %g s", kSetupKind, stamp, exposure);
    return {static_cast<Stamp>(stamp), exposure};
}

// may_be_none: whether the frames need not be reduced.
Reference read_reference(ByteReader &in, bool may_be_none) {
    Reference reference;
    const uint32_t in_orbit = in.u32();
    reference.in_orbit = in_orbit != 0;
    reference.scale_arcsec = in.f64();
    const size_t size = in.u32();
    if (may_be_none && size == 0 && reference.scale_arcsec == 0 && in_orbit == 0)
        return reference;
    if (!(reference.scale_arcsec > 0 && reference.scale_arcsec <= kMostScale) || size < 1 || size > kLongestSystem ||
        size > in.left() || in_orbit > 1)
        fail(Status::format, "%s: system of %zu bytes, plate scale %g", kSetupKind, size, reference.scale_arcsec);
    reference.system.assign(reinterpret_cast<const char *>(in.raw(size)), size);
    return reference;
}

period::Grid read_grid(ByteReader &in) {
    constexpr size_t kStart = period::Stream::kHeaderSize;
    const uint8_t *const start = in.raw(kStart);
    const size_t size = period::Stream::header_size(start);
    in.raw(size - kStart);
    return period::Stream::load_header(start, size);
}

OrbitErrors read_errors(ByteReader &in, const period::Grid &grid, const Reference &reference) {
    OrbitErrors errors;
    bool are_known = reference.is_given() || grid.basis.columns == 0;
    for (double &sigma : errors.sigmas) {
        sigma = in.f64();
        are_known = are_known && sigma >= 0 && std::isfinite(sigma);
    }
    errors.scale_sigma = in.f64();
    if (!are_known || !(errors.scale_sigma >= 0 && errors.scale_sigma < 1) ||
        errors.count() != static_cast<size_t>(grid.basis.columns))
        fail(Status::format, "%s: errors of %zu elements in %d columns, of the plate scale %g", kSetupKind,
             errors.count(), grid.basis.columns, errors.scale_sigma);
    return errors;
}

// The limit of chi-square, and what is known of the model.
void read_limit(ByteReader &in, Setup &setup) {
    setup.chi_limit = in.f64();
    const uint32_t flags = in.u32(), verdict = in.u32();
    Goodness &goodness = setup.model.goodness;
    for (double *number : {&goodness.chi_square, &goodness.sigma, &goodness.largest})
        *number = in.f64();
    if (!(setup.chi_limit >= 0 && std::isfinite(setup.chi_limit)) || flags > 3 ||
        verdict > static_cast<uint32_t>(GoodnessVerdict::too_good))
        fail(Status::format, "%s: limit of chi-square %g, flags %u, goodness %u", kSetupKind, setup.chi_limit, flags,
             verdict);
    setup.model.is_calibrated = (flags & 1) != 0;
    setup.model.is_complete = (flags & 2) != 0;
    goodness.verdict = static_cast<GoodnessVerdict>(verdict);
}

void write_limit(const Setup &setup, ByteWriter &out) {
    const ModelVerdict &model = setup.model;
    out.f64(setup.chi_limit);
    out.u32((model.is_calibrated ? 1 : 0) | (model.is_complete ? 2 : 0));
    out.u32(static_cast<uint32_t>(model.goodness.verdict));
    for (const double number : {model.goodness.chi_square, model.goodness.sigma, model.goodness.largest})
        out.f64(number);
}

Setup read_setup(const std::vector<uint8_t> &bytes) {
    auto [in, version] = checked_content(bytes, kSetupMagic, kSetupVersion, kSetupKind);
    const size_t count = in.u32();
    if (count > in.left() / kPointSize)
        fail(Status::format, "%s: %zu clock points exceed the size of the file", kSetupKind, count);
    std::vector<ClockPoint> points(count);
    for (ClockPoint &point : points) {
        point.camera_ns = in.i64();
        point.tai_ns = in.i64();
    }
    Setup setup = {read_grid(in), Clock(std::move(points))};
    if (version > kVersionWithoutTiming)
        setup.timing = read_timing(in);
    if (version > kVersionWithoutReference) {
        setup.salt = in.u64();
        setup.reference = read_reference(in, version > kVersionWithoutFunctions);
    }
    if (version > kVersionWithoutFunctions)
        setup.errors = read_errors(in, setup.grid, setup.reference);
    if (version == kSetupVersion)
        read_limit(in, setup);
    if (version < kSetupVersion && setup.grid.basis.any() != (version == kVersionWithoutLimit))
        fail(Status::format, "%s: version %u with %zu functions", kSetupKind, version, setup.grid.basis.functions());
    if (in.left() > 0)
        fail(Status::format, "%s: has %zu extra bytes", kSetupKind, in.left());
    return setup;
}

std::optional<Setup> load(Store &store, const char *name) {
    return read_if_whole(store, name, kFramingSize, kLargestSetup, read_setup);
}

bool is_of_ledger(const Setup &setup, Store &store) {
    return store.size(LedgerFile::kName) < 0 || setup.salt == LedgerFile(store).salt();
}

std::optional<Setup> load_new(Store &store) {
    std::optional<Setup> setup = load(store, Setup::kNewName);
    return setup && setup->reference.is_given() && is_of_ledger(*setup, store) ? setup : std::nullopt;
}

} // namespace

uint32_t Setup::digest() const {
    const std::vector<uint8_t> bytes = to_bytes(*this);
    return ByteReader(bytes.data() + bytes.size() - 4, 4, kSetupKind).u32();
}

// Earlier versions are written with the default limit, without nuisance functions, without a reference, and with the
// default timing, so that older folders keep their bytes and their checkpoints stay valid.
std::vector<uint8_t> to_bytes(const Setup &setup) {
    const bool has_limit = setup.chi_limit != 0 || setup.model.is_calibrated;
    const bool has_functions = has_limit || setup.grid.basis.any();
    const bool has_reference = has_functions || setup.reference.is_given();
    const bool has_timing = has_reference || !(setup.timing == Timing());
    ByteWriter out = begin_file(kSetupMagic, has_limit       ? kSetupVersion
                                             : has_functions ? kVersionWithoutLimit
                                             : has_reference ? kVersionWithoutFunctions
                                             : has_timing    ? kVersionWithoutReference
                                                             : kVersionWithoutTiming);
    out.u32(static_cast<uint32_t>(setup.clock.points().size()));
    for (const ClockPoint &point : setup.clock.points()) {
        out.i64(point.camera_ns);
        out.i64(point.tai_ns);
    }
    const std::vector<uint8_t> grid = period::Stream::header(setup.grid);
    out.raw(grid.data(), grid.size());
    if (has_timing) {
        out.u32(static_cast<uint32_t>(setup.timing.stamp));
        out.f64(setup.timing.exposure_s);
    }
    if (has_reference) {
        out.u64(setup.salt);
        out.u32(setup.reference.in_orbit ? 1 : 0);
        out.f64(setup.reference.scale_arcsec);
        out.u32(static_cast<uint32_t>(setup.reference.system.size()));
        out.raw(setup.reference.system.data(), setup.reference.system.size());
    }
    if (has_functions) {
        for (const double sigma : setup.errors.sigmas)
            out.f64(sigma);
        out.f64(setup.errors.scale_sigma);
    }
    if (has_limit)
        write_limit(setup, out);
    return finish_file(std::move(out));
}

void check_reference(const Reference &in_file, const Reference &own, const std::string &path) {
    if (in_file == own)
        return;
    if (!in_file.is_given() || !own.is_given())
        fail(Status::mismatch, "{%s}: its frames are %s, those of this tracker are%s: rebuild to change it",
             path.c_str(), in_file.is_given() ? "reduced" : "not reduced", own.is_given() ? "" : " not");
    if (in_file.in_orbit != own.in_orbit)
        fail(Status::mismatch, "{%s}: is reduced for an observer %s, this tracker for one %s: rebuild to change it",
             path.c_str(), place_of(in_file), place_of(own));
    if (in_file.scale_arcsec != own.scale_arcsec)
        fail(Status::mismatch, "{%s}: has a plate scale of %.17g arcsec per px, not %.17g: rebuild to change it",
             path.c_str(), in_file.scale_arcsec, own.scale_arcsec);
    fail(Status::mismatch, "{%s}: has another system, the reference orbit of its frames: rebuild to change it",
         path.c_str());
}

void check_timing(const Timing &in_file, const Timing &own, const std::string &path) {
    if (!(in_file == own))
        fail(Status::mismatch,
             "{%s}: has time stamps at the %s of exposures of %g s, not at the %s of %g s (0 s: unknown)", path.c_str(),
             name_of(in_file.stamp), in_file.exposure_s, name_of(own.stamp), own.exposure_s);
}

period::Grid for_terms(period::Grid grid, const Terms &terms) {
    int exponent;
    const bool is_power = std::frexp(terms.value_limit, &exponent) == 0.5;
    grid.value_bound =
        is_power ? terms.value_limit : std::ldexp(1.0, exponent); // the smallest power of two that is not below
    grid.value_offset = grid.time_offset = 0;
    grid.sigma_floor = terms.sigma;
    grid.sigma_ceiling = Terms::kMaxSigmaRatio * terms.sigma;
    return grid;
}

std::optional<Setup> load_setup(Store &store) {
    if (std::optional<Setup> setup = load_new(store))
        return setup;
    std::optional<Setup> setup = load(store, Setup::kName);
    return setup && (!setup->reference.is_given() || is_of_ledger(*setup, store)) ? setup : std::nullopt;
}

void settle_setup(Store &store) {
    if (!load_new(store))
        return;
    store.rename(Setup::kNewName, Setup::kName);
    store.sync_folder();
}

} // namespace toliman::track
