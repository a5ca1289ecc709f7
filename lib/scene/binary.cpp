#include <algorithm>
#include <string_view>

#include "scene/groups.hpp"
#include "scene/system.hpp"

namespace toliman::scene {

namespace {

constexpr std::string_view kSuffix = ".json";
constexpr Condition kNoOffsets = without("offsets_px", "not allowed with offsets_px, which gives the stars' positions");
constexpr Condition kNoOrbit =
    without("orbit date", "not allowed with date and orbit, which give the stars' positions");
constexpr Condition kByOrbit = with("orbit date", "needs date and orbit");

// A system brings its orbit.
void read_orbit(const Reader &reader, const Row &row, Binary &binary) {
    if (reader.has_object(row.key)) {
        read_group(kOrbit, reader.object(row.key), &binary.orbit.emplace());
        return;
    }
    const std::string &given = reader.text(row.key);
    const bool is_file = given.size() > kSuffix.size() && given.substr(given.size() - kSuffix.size()) == kSuffix;
    if (!is_file)
        reader.choice(row);
    binary.system = is_file ? read_system(reader.file(row.key)) : sky::alpha_cen();
    binary.orbit = binary.system->value.orbit;
}

struct GivenObserver {
    std::string file;
    sky::CircularOrbit orbit;
};
constexpr Condition kCircular = with("altitude_km", "needs altitude_km");
void read_altitude(const Reader &reader, const Row &row, GivenObserver &given) {
    given.orbit.altitude_km = reader.number(row);
}
void read_node(const Reader &reader, const Row &row, GivenObserver &given) {
    given.orbit.node_hours = reader.number(row);
}
constexpr Row kObserverRows[] = {
    required<read_altitude>("altitude_km", within(200, 2000, "km"), "Altitude of a circular sun-synchronous orbit")
        .as(Type::number)
        .either("file"),
    optional<read_node>("node_hours", above(0, 24, "h"),
                        "Local mean time at its ascending node; 18, the default: above the terminator")
        .as(Type::number)
        .when(kCircular),
    optional<&GivenObserver::file>("file", "Observer file, CCSDS OEM or CSV (formats.md)"),
};
constexpr Group kObserver = group_of("observer", "Place and velocity of the camera", kObserverRows);

sky::Observer observer_of(const Reader &reader, const Row &row) {
    GivenObserver given;
    read_group(kObserver, reader.object(row.key), &given);
    if (given.file.empty())
        return sky::Observer(given.orbit);
    const ingest::LeapSeconds leap_seconds(erfa::leap_seconds().rows);
    return sky::Observer(std::make_shared<const sky::Ephemeris>(sky::read_ephemeris(given.file, leap_seconds, {})));
}

void read_observer(const Reader &reader, const Row &row, Binary &binary) {
    const bool is_object = reader.has_object(row.key);
    if (!is_object && reader.choice(row) == 0)
        return;
    if (!binary.system)
        reader.refuse(Status::scene, row.key, ": needs an orbit with a system: \"alpha-cen\" or a system file");
    const sky::Observer observer = is_object ? observer_of(reader, row) : sky::Observer();
    binary.sky = std::make_shared<const sky::Predictor>(*binary.system, observer);
}

template <size_t star> void read_offset(const Reader &reader, const Row &row, Binary &binary) {
    const std::vector<double> offset = reader.numbers(row);
    std::copy(offset.begin(), offset.end(), binary.offsets_px + 2 * star);
}

constexpr Range kOffset = within(-1e4, 1e4, "px");
constexpr Row kOffsetRows[] = {
    required<read_offset<0>>("A", kOffset, "[x, y] of star A").as(Type::numbers).entries(2, 2),
    optional<read_offset<1>>("B", kOffset, "[x, y] of star B").as(Type::numbers).entries(2, 2),
};
constexpr Group kOffsetA = {"offset", "Position of a single star", kOffsetRows, 1};
constexpr Group kOffsets =
    group_of("offsets", "Positions of the stars relative to the frame's axis: x to higher columns, y to higher rows",
             kOffsetRows);

void read_offsets(const Reader &reader, const Row &row, Binary &binary) {
    const bool single = reader.scene().stars.size() == 1;
    const Reader offsets = reader.object(row.key);
    read_group(single ? kOffsetA : kOffsets, offsets, &binary);
    if (!single && !offsets.has("B"))
        offsets.refuse(Status::scene, "B", ": is missing");
    binary.by_offsets = true;
    const double *offset = binary.offsets_px;
    if (!single && std::equal(offset, offset + 2, offset + 2))
        reader.refuse(Status::scene, row.key, ": both stars are at (%g, %g) px: the separation has no direction",
                      offset[0], offset[1]);
}

constexpr Row kBinaryRows[] = {
    optional<&Binary::distance_pc>("distance_pc", above(0, 1e6, "pc"), "Distance; for a planet"),
    optional<read_offsets>("offsets_px", &kOffsets, "Positions of the stars relative to the frame's axis"),
    required<&Binary::date>("date", kDate,
                            "Date of time 0, Julian year of 365.25 days, e.g. 2027.0; the stars keep these positions "
                            "unless moving is true")
        .when(kNoOffsets, kByOrbit),
    required<read_orbit>("orbit", &kOrbit,
                         "Orbit of B about A; alpha-cen: Akeson et al. 2021, AJ 162, 14; or a system file, "
                         "NAME.json (schema toliman-system/1); or elements")
        .or_word("alpha-cen")
        .as(Type::word_file_or_group)
        .when(kNoOffsets, kByOrbit),
    optional<&Binary::moving>("moving", "Whether the stars follow the orbit during the cadence")
        .when(kNoOffsets, kByOrbit),
    optional<read_observer>("observer", &kObserver,
                            "From where the moving stars are seen; none: their orbit; earth: with parallax, aberration "
                            "and light time at the Earth's centre")
        .or_word("none earth")
        .when(kNoOffsets, kByOrbit),
    required<&Binary::separation_arcsec>("separation_arcsec", within(1e-6, 1e5, "arcsec"), "Separation")
        .when(kNoOffsets, kNoOrbit),
    optional<&Binary::position_angle_deg>("position_angle_deg", kTurn,
                                          "Position angle of B seen from A, from +y (north) towards -x (east)")
        .when(kNoOffsets, kNoOrbit),
    optional<&Binary::centre>("centre", Words{"barycentre A B"}, "Point on the frame's axis; barycentre: of the light")
        .when(kNoOffsets),
};

} // namespace

constexpr Group kBinary = group_of(
    "binary", "Positions of the stars; required for two stars, optional (offsets_px) for one star", kBinaryRows);

} // namespace toliman::scene
