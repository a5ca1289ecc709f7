#include "scene/system.hpp"

#include <cmath>

#include "backend/file.hpp"
#include "scene/groups.hpp"

namespace toliman::scene {

namespace {

using sky::Barycentre;
using sky::Elements;
using sky::Masses;
using sky::Orbit;
using sky::Refitted;
using sky::System;

constexpr size_t kLargestSystem = size_t{1} << 18;
constexpr const char *kSourceText = "Where the numbers are from";

template <class T> void read_source(const Reader &reader, const Row &row, T & /*object*/) {
    reader.text(row.key);
}
template <class T> constexpr Row source() {
    return optional<read_source<T>>("source", kSourceText).as(Type::text);
}

constexpr Row kOrbitRows[] = {
    required<&Orbit::period_years>("period_years", within(1e-4, 1e6, "years"), "Period in years of 365.25 days"),
    required<&Orbit::semi_major_arcsec>("semi_major_arcsec", within(1e-3, 1e5, "arcsec"), "Semi-major axis"),
    required<&Orbit::eccentricity>("eccentricity", kEccentricity, "Eccentricity"),
    required<&Orbit::inclination_deg>("inclination_deg", within(0, 180, "deg"),
                                      "Inclination; below 90 the position angle increases"),
    required<&Orbit::node_deg>("node_deg", kTurn,
                               "Position angle of the ascending node, at which B recedes. The other node, with "
                               "periastron_deg 180 deg larger, gives the same positions, but reverses the depth, "
                               "and with it the sign of the differential parallax"),
    required<&Orbit::periastron_deg>("periastron_deg", kTurn,
                                     "Angle from the ascending node to the periastron of B, in the direction of "
                                     "motion"),
    required<&Orbit::epoch>("epoch", kDate, "Date of a passage through periastron, Julian year"),
    source<Orbit>(),
};

void read_radial_velocity(const Reader &reader, const Row &row, Barycentre &centre) {
    centre.radial_velocity_km_s = reader.number(row);
}
void subtract_shift(const Reader &reader, const Row &row, Barycentre &centre) {
    centre.radial_velocity_km_s -= reader.number(row);
}

constexpr Range kVelocity = within(-1e4, 1e4, "km/s"), kMotion = within(-1e5, 1e5, "mas/yr");
constexpr Row kBarycentreRows[] = {
    required<&Barycentre::ra_deg>("ra_deg", within(0, 360, "deg"), "Right ascension, ICRS, at the epoch"),
    required<&Barycentre::dec_deg>("dec_deg", within(-90, 90, "deg"), "Declination, ICRS, at the epoch"),
    required<&Barycentre::epoch>("epoch", kDate,
                                 "Date of the place, Julian year; orbital dates refer to the light "
                                 "time from the distance of this date"),
    required<&Barycentre::pm_ra_mas_yr>("pm_ra_mas_yr", kMotion,
                                        "Proper motion in right ascension times cos(declination)"),
    required<&Barycentre::pm_dec_mas_yr>("pm_dec_mas_yr", kMotion, "Proper motion in declination"),
    required<&Barycentre::parallax_mas>("parallax_mas", within(1e-3, 770, "mas"),
                                        "Parallax at the epoch; that of the nearest star is 768 mas"),
    required<read_radial_velocity>("radial_velocity_km_s", kVelocity, "Radial velocity; positive: recedes")
        .as(Type::number),
    required<check_word<Barycentre>>("radial_velocity_kind", Words{"kinematic spectroscopic"},
                                     "kinematic: velocity of the motion; spectroscopic: of the lines of the spectrum"),
    required<subtract_shift>("line_shift_km_s", within(-10, 10, "km/s"),
                             "Shift of the lines by gravity and convection, which is subtracted")
        .as(Type::number)
        .when(is("radial_velocity_kind", "spectroscopic", "needs radial_velocity_kind spectroscopic")),
    source<Barycentre>(),
};
constexpr Group kBarycentre =
    group_of("barycentre", "Place and motion of the barycentre of the two stars", kBarycentreRows);

constexpr Range kMass = within(0.01, 500, "solar masses");
constexpr Row kMassesRows[] = {
    required<&Masses::a_sun>("A", kMass, "Mass of star A"),
    required<&Masses::b_sun>("B", kMass, "Mass of star B"),
    source<Masses>(),
};
constexpr Group kMasses = group_of("masses", "Masses of the stars", kMassesRows);

constexpr const char *kSigmaText = "Standard deviation";
constexpr Range sigma_in(const char *unit) {
    return within(0, 1e6, unit);
}
constexpr Row kOrbitSigmaRows[] = {
    optional<&Orbit::period_years>("period_years", sigma_in("years"), kSigmaText),
    optional<&Orbit::semi_major_arcsec>("semi_major_arcsec", sigma_in("arcsec"), kSigmaText),
    optional<&Orbit::eccentricity>("eccentricity", sigma_in(""), kSigmaText),
    optional<&Orbit::inclination_deg>("inclination_deg", sigma_in("deg"), kSigmaText),
    optional<&Orbit::node_deg>("node_deg", sigma_in("deg"), kSigmaText),
    optional<&Orbit::periastron_deg>("periastron_deg", sigma_in("deg"), kSigmaText),
    optional<&Orbit::epoch>("epoch", sigma_in("years"), kSigmaText),
};
constexpr Group kOrbitSigma = group_of("orbit_sigma", "Errors of the orbit", kOrbitSigmaRows);
constexpr Row kBarycentreSigmaRows[] = {
    optional<&Barycentre::ra_deg>("ra_deg", sigma_in("deg"), kSigmaText),
    optional<&Barycentre::dec_deg>("dec_deg", sigma_in("deg"), kSigmaText),
    optional<&Barycentre::pm_ra_mas_yr>("pm_ra_mas_yr", sigma_in("mas/yr"), kSigmaText),
    optional<&Barycentre::pm_dec_mas_yr>("pm_dec_mas_yr", sigma_in("mas/yr"), kSigmaText),
    optional<&Barycentre::parallax_mas>("parallax_mas", sigma_in("mas"), kSigmaText),
    optional<&Barycentre::radial_velocity_km_s>("radial_velocity_km_s", sigma_in("km/s"), kSigmaText),
};
constexpr Group kBarycentreSigma = group_of("barycentre_sigma", "Errors of place and motion", kBarycentreSigmaRows);
constexpr Row kMassesSigmaRows[] = {
    optional<&Masses::a_sun>("A", sigma_in("solar masses"), kSigmaText),
    optional<&Masses::b_sun>("B", sigma_in("solar masses"), kSigmaText),
};
constexpr Group kMassesSigma = group_of("masses_sigma", "Errors of the masses", kMassesSigmaRows);

constexpr Row kSigmaRows[] = {
    optional<&Elements::orbit>("orbit", &kOrbitSigma),
    optional<&Elements::barycentre>("barycentre", &kBarycentreSigma),
    optional<&Elements::masses>("masses", &kMassesSigma),
};
constexpr Group kSigma = group_of("sigma", "Standard deviations of the numbers; 0 or not given: not known", kSigmaRows);

void read_system_name(const Reader &reader, const Row &row, System &system) {
    system.name = reader.text(row.key);
}
template <auto member> void read_value(const Reader &reader, const Row &row, System &system) {
    read_group(*row.group, reader.object(row.key), &(system.value.*member));
}

constexpr Row kRefitRows[] = {
    required<&Refitted::first>("first", kDate, "Date of the first measurement, Julian year"),
    required<&Refitted::last>("last", kDate, "Date of the last measurement, Julian year"),
};
constexpr Group kRefit = group_of(
    "refit", "The measurements to which the orbit was refitted, which must not be searched with it", kRefitRows);

void check_refit(const Reader &reader, const System &system) {
    if (system.refit && !(system.refit->first <= system.refit->last))
        reader.refuse(Status::scene, "refit", ": first = %g: must not be after last = %g", system.refit->first,
                      system.refit->last);
}

constexpr double kMostVelocity = 1e4;  // km/s, of stars in any galaxy that is near enough
constexpr double kMostMassRatio = 100; // of the masses to those of the orbit: a wrong unit gives 1e9

// Units that are mistaken, as a parallax in arcsec, give motions and masses that no star has.
void check_units(const Reader &reader, const System &system) {
    constexpr double kPerYear = 4.740470446; // km/s, of an au
    const auto &[orbit, centre, masses] = system.value;
    const double motion = std::hypot(centre.pm_ra_mas_yr, centre.pm_dec_mas_yr) / centre.parallax_mas * kPerYear;
    if (!(motion <= kMostVelocity))
        reader.refuse(Status::scene, "barycentre",
                      ": the proper motion at this parallax is %.3g km/s: must be at most %g: are both in mas?", motion,
                      kMostVelocity);
    const double axis_au = orbit.semi_major_arcsec * 1000 / centre.parallax_mas;
    const double found = axis_au * axis_au * axis_au / (orbit.period_years * orbit.period_years),
                 ratio = found / (masses.a_sun + masses.b_sun);
    if (!(ratio <= kMostMassRatio && ratio >= 1 / kMostMassRatio))
        reader.refuse(Status::scene, "masses",
                      ": Kepler's third law gives %.3g solar masses for orbit and parallax, these are %.3g: must be "
                      "within a factor of %g",
                      found, masses.a_sun + masses.b_sun, kMostMassRatio);
}

constexpr Row kSystemRows[] = {
    required<check_word<System>>("schema", Words{"toliman-system/1"}, "Schema of the file"),
    optional<read_system_name>("name", "Name of the binary").as(Type::text),
    required<read_value<&Elements::orbit>>("orbit", &kOrbit),
    required<read_value<&Elements::barycentre>>("barycentre", &kBarycentre),
    required<read_value<&Elements::masses>>("masses", &kMasses).checked<check_units>(),
    optional<&System::sigma>("sigma", &kSigma),
    optional<&System::refit>("refit", &kRefit).checked<check_refit>(),
};

// is_sigma: numbers that are 0 are not known, and left out.
void set_elements(const Elements &elements, bool is_sigma, json::Value &tree) {
    const auto set = [&](const char *group, const char *key, double value) {
        if (!is_sigma || value != 0)
            tree.member(group).member(key) = json::Value::of(value);
    };
    const Orbit &orbit = elements.orbit;
    const Barycentre &centre = elements.barycentre;
    set("orbit", "period_years", orbit.period_years);
    set("orbit", "semi_major_arcsec", orbit.semi_major_arcsec);
    set("orbit", "eccentricity", orbit.eccentricity);
    set("orbit", "inclination_deg", orbit.inclination_deg);
    set("orbit", "node_deg", orbit.node_deg);
    set("orbit", "periastron_deg", orbit.periastron_deg);
    set("orbit", "epoch", orbit.epoch);
    set("barycentre", "ra_deg", centre.ra_deg);
    set("barycentre", "dec_deg", centre.dec_deg);
    if (!is_sigma)
        set("barycentre", "epoch", centre.epoch);
    set("barycentre", "pm_ra_mas_yr", centre.pm_ra_mas_yr);
    set("barycentre", "pm_dec_mas_yr", centre.pm_dec_mas_yr);
    set("barycentre", "parallax_mas", centre.parallax_mas);
    set("barycentre", "radial_velocity_km_s", centre.radial_velocity_km_s);
    if (!is_sigma)
        tree.member("barycentre").member("radial_velocity_kind") = json::Value::of("kinematic");
    set("masses", "A", elements.masses.a_sun);
    set("masses", "B", elements.masses.b_sun);
}

} // namespace

constexpr Group kOrbit = group_of("orbit", "Elements of the motion of B about A", kOrbitRows);
constexpr Group kSystem =
    group_of("system",
             "A binary star, from which the separation is predicted that an observer sees. Key names contain the units",
             kSystemRows);

} // namespace toliman::scene

namespace toliman {

sky::System read_system(const std::string &json, const std::string &source) {
    const json::Value tree = json::parse(json, source);
    const Scene none;
    const std::string folder = ".";
    const scene::Context context = {source, folder, none, "the system"};
    sky::System system = {};
    read_group(scene::kSystem, scene::Reader(tree, "", context), &system);
    return system;
}

sky::System read_system(const std::string &path) {
    const std::vector<uint8_t> bytes = file::read(path, scene::kLargestSystem);
    return read_system(std::string(bytes.begin(), bytes.end()), path);
}

sky::System named_system(const std::string &name) {
    if (name.empty())
        fail(Status::argument, "{system} = \"\": must be \"alpha-cen\" or a system file");
    const size_t first = name.find_first_not_of(" \t\r\n");
    if (first != name.npos && name[first] == '{')
        return read_system(name, "system");
    return name == "alpha-cen" ? sky::alpha_cen() : read_system(name);
}

std::string system_json(const sky::System &system) {
    json::Value tree;
    tree.member("schema") = json::Value::of("toliman-system/1");
    if (!system.name.empty())
        tree.member("name") = json::Value::of(system.name);
    scene::set_elements(system.value, false, tree);
    json::Value sigma;
    scene::set_elements(system.sigma, true, sigma);
    if (sigma.kind == json::Value::Kind::object)
        tree.member("sigma") = std::move(sigma);
    if (system.refit) {
        tree.member("refit").member("first") = json::Value::of(system.refit->first);
        tree.member("refit").member("last") = json::Value::of(system.refit->last);
    }
    return json::print(tree);
}

} // namespace toliman
