#include <algorithm>

#include "optics/scene_groups.hpp"

namespace toliman::optics {

namespace {

constexpr Range kDate = within(-1e4, 1e4, "years");

void read_offset(const Reader &offsets, size_t star, Binary &result) {
    const std::vector<double> offset = offsets.numbers(kStarNames[star], 2, 2, within(-1e4, 1e4, "px"));
    std::copy(offset.begin(), offset.end(), result.offsets_px + 2 * star);
}

void read_offsets(const Reader &binary, size_t stars, Binary &result) {
    binary.exclude({"separation_arcsec", "position_angle_deg", "centre", "date", "orbit", "moving"},
                   "not allowed with offsets_px, which gives the stars' positions");
    binary.allow({"offsets_px", "distance_pc"});
    const Reader reader = binary.object("offsets_px");
    if (stars == 2)
        reader.allow({"A", "B"});
    else
        reader.allow({"A"});
    result.by_offsets = true;
    read_offset(reader, 0, result);
    if (stars == 2)
        read_offset(reader, 1, result);
    const double *offset = result.offsets_px;
    if (stars == 2 && std::equal(offset, offset + 2, offset + 2))
        binary.refuse(Status::scene, "offsets_px", ": both stars are at (%g, %g) px: the separation has no direction",
                      offset[0], offset[1]);
}

Orbit read_elements(const Reader &reader) {
    reader.allow({"period_years", "semi_major_arcsec", "eccentricity", "inclination_deg", "node_deg", "periastron_deg",
                  "epoch"});
    Orbit orbit;
    orbit.period_years = reader.number("period_years", above(0, 1e6, "years"));
    orbit.semi_major_arcsec = reader.number("semi_major_arcsec", above(0, 1e5, "arcsec"));
    orbit.eccentricity = reader.number("eccentricity", kEccentricity);
    orbit.inclination_deg = reader.number("inclination_deg", within(0, 180, "deg"));
    orbit.node_deg = reader.number("node_deg", kTurn);
    orbit.periastron_deg = reader.number("periastron_deg", kTurn);
    orbit.epoch = reader.number("epoch", kDate);
    return orbit;
}

// The date is time 0 of the cadence.
void read_orbit(const Reader &reader, Binary &binary) {
    if (reader.has_object("orbit")) {
        binary.orbit = read_elements(reader.object("orbit"));
    } else {
        reader.choice("orbit", {"alpha-cen"});
        binary.orbit = kAlphaCen;
    }
    binary.years = reader.number("date", kDate) - binary.orbit->epoch;
    binary.position = position_on_orbit(*binary.orbit, binary.years);
    if (binary.position.separation_arcsec == 0)
        reader.refuse(Status::scene, "orbit", ": both stars are at the same position: the separation has no direction");
    binary.moving = reader.boolean_or("moving", false);
}

} // namespace

Binary read_binary(const Reader &scene, size_t stars) {
    Binary binary;
    if (!scene.has("binary")) {
        if (stars == 2)
            scene.refuse(Status::scene, "binary", ": is missing: two stars need their positions");
        return binary;
    }
    const Reader reader = scene.object("binary");
    binary.distance_pc = reader.optional_number("distance_pc", above(0, 1e6, "pc"));
    if (reader.has("offsets_px")) {
        read_offsets(reader, stars, binary);
        return binary;
    }
    const bool by_orbit = reader.has("orbit") || reader.has("date");
    if (by_orbit) {
        reader.exclude({"separation_arcsec", "position_angle_deg"},
                       "not allowed with date and orbit, which give the stars' positions");
        reader.allow({"date", "orbit", "moving", "centre", "distance_pc"});
    } else {
        reader.exclude({"moving"}, "needs date and orbit");
        reader.allow(
            {"separation_arcsec", "position_angle_deg", "centre", "offsets_px", "date", "orbit", "distance_pc"});
    }
    if (stars == 1)
        scene.refuse(Status::scene, "binary", ": a single star allows offsets_px only");
    if (by_orbit) {
        read_orbit(reader, binary);
    } else {
        binary.position.separation_arcsec = reader.number("separation_arcsec", within(1e-6, 1e5, "arcsec"));
        binary.position.position_angle_deg = reader.number_or("position_angle_deg", 0, kTurn);
    }
    if (reader.has("centre"))
        binary.centre = static_cast<Binary::Centre>(reader.choice("centre", {"barycentre", "A", "B"}));
    return binary;
}

} // namespace toliman::optics
