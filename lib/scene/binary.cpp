#include <algorithm>

#include "scene/groups.hpp"

namespace toliman::scene {

namespace {

constexpr Range kDate = within(-1e4, 1e4, "years");
constexpr Condition kNoOffsets = without("offsets_px", "not allowed with offsets_px, which gives the stars' positions");
constexpr Condition kNoOrbit =
    without("orbit date", "not allowed with date and orbit, which give the stars' positions");
constexpr Condition kByOrbit = with("orbit date", "needs date and orbit");

constexpr Row kOrbitRows[] = {
    required<&Orbit::period_years>("period_years", above(0, 1e6, "years"), "Period in years of 365.25 days"),
    required<&Orbit::semi_major_arcsec>("semi_major_arcsec", above(0, 1e5, "arcsec"), "Semi-major axis"),
    required<&Orbit::eccentricity>("eccentricity", kEccentricity, "Eccentricity"),
    required<&Orbit::inclination_deg>("inclination_deg", within(0, 180, "deg"),
                                      "Inclination; below 90 the position angle increases"),
    required<&Orbit::node_deg>("node_deg", kTurn,
                               "Position angle of a node; either of the two nodes, if periastron_deg is measured from "
                               "the same one"),
    required<&Orbit::periastron_deg>("periastron_deg", kTurn,
                                     "Angle from that node to the periastron of B, in the direction of motion"),
    required<&Orbit::epoch>("epoch", kDate, "Date of a passage through periastron, Julian year"),
};
constexpr Group kOrbit = group_of("orbit", "Elements of the motion of B about A", kOrbitRows);

void read_orbit(const Reader &reader, const Row &row, Binary &binary) {
    binary.orbit = kAlphaCen;
    if (reader.has_object(row.key))
        read_group(kOrbit, reader.object(row.key), &*binary.orbit);
    else
        reader.choice(row);
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
    required<read_orbit>("orbit", &kOrbit, "Orbit of B about A; alpha-cen: Akeson et al. 2021, AJ 162, 14; or elements")
        .or_word("alpha-cen")
        .when(kNoOffsets, kByOrbit),
    optional<&Binary::moving>("moving", "Whether the stars follow the orbit during the cadence")
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
