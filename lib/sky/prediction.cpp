// Method: both stars move with the barycentre of the system, in a straight line, and about it on the orbit, in three
// dimensions. A star is seen where it was when its light left it,
//     t_star = t - (|r_star(t_star) - r_observer| - D)/c,
// where D is the distance at the epoch of the catalogue, to which the times of orbital elements refer. Its direction is
// then bent by the Sun and changed by the exact aberration of the observer's velocity. Angles between directions are
// atan2 of products of vectors: acos loses half of the digits.
// Time: the geometric separation is that of the orbit when the light of the barycentre passes the barycentre of the
// solar system, t + r_observer . n/c.
// The separation s depends on the elements through the geometric separation g, the position angle p and the distance z
// of B behind A, where s(c g, p, c z) = c s(g, p, z). With F = s/g,
//     (1/F) ds/de = (1 - z/s ds/dz) dg/de + (1/F) (ds/dp dp/de + ds/dz dz/de).
// ds/dp and ds/dz follow from the separation of A and a star B that is turned about A, or is farther away.
// Error: within 1e-4 uas of the same equations in 50 digits. sky.md lists the omitted effects, below 0.03 uas.
// Reference: ERFA (Sun, aberration); Klioner 2003, AJ 125, 1580.
#include "sky/prediction.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "sky/time.hpp"
#include "sky/vector.hpp"

namespace toliman::sky {

namespace {

constexpr double kLightYear = erfa::kLightSpeed * kSecondsPerDay * kDaysPerYear / erfa::kAstronomicalUnit; // au
constexpr int64_t kFarthestNs = 36524 * kNsPerDay; // from J2000.0; ERFA's Earth is valid from 1900 to 2100
constexpr int64_t kLongestInterval = 400 * kNsPerDay;
constexpr double kTurn = 1e-3, kFarther = 10; // of star B; rad, and arcsec at the distance of the system
constexpr int kLightTimeSteps = 4;            // each reduces the error by the velocity over c, 1e-4

Vector unit(const Vector &a) noexcept {
    const double size = length(a);
    return {a[0] / size, a[1] / size, a[2] / size};
}

void check_time(int64_t tai_ns) {
    constexpr int64_t kMiddle = kJ2000Ns - kTtMinusTaiNs;
    if (tai_ns < kMiddle - kFarthestNs || tai_ns > kMiddle + kFarthestNs)
        fail(Status::range, "{time} = %lld ns TAI: must be from 1900-01-01T12 to 2099-12-31T12 TT",
             static_cast<long long>(tai_ns));
}

// Gauss-Legendre nodes on [-1, 1] with half of their weights: 2 for panels up to kShortPanel, otherwise 4.
struct Node {
    double place, weight;
};
constexpr double kShortPanel = 120e9, kLongPanel = 600e9; // ns; errors below 2e-5 uas in a low orbit
constexpr Node kTwoNodes[] = {{-0.57735026918962576, 0.5}, {0.57735026918962576, 0.5}};
constexpr Node kFourNodes[] = {{-0.86113631159405258, 0.17392742256872693},
                               {-0.33998104358485626, 0.32607257743127307},
                               {0.33998104358485626, 0.32607257743127307},
                               {0.86113631159405258, 0.17392742256872693}};

// Adds `weight` times the prediction, angles relative to those of `first`.
void accumulate(const Prediction &value, double weight, const Prediction &first, Prediction &total) noexcept {
    total.separation_arcsec += weight * value.separation_arcsec;
    total.geometric_arcsec += weight * value.geometric_arcsec;
    total.position_angle_deg += weight * std::remainder(value.position_angle_deg - first.position_angle_deg, 360);
    total.geometric_angle_deg += weight * std::remainder(value.geometric_angle_deg - first.geometric_angle_deg, 360);
    total.barycentric_offset_s += weight * value.barycentric_offset_s;
    total.approach_m_s += weight * value.approach_m_s;
    total.sun_angle_deg += weight * value.sun_angle_deg;
    for (size_t i = 0; i < kElements; i++)
        total.partials[i] += weight * value.partials[i];
}

void check_disjoint(std::vector<Interval> intervals) {
    std::sort(intervals.begin(), intervals.end(),
              [](const Interval &a, const Interval &b) { return a.start_ns < b.start_ns; });
    for (size_t i = 1; i < intervals.size(); i++)
        if (intervals[i].start_ns < intervals[i - 1].end_ns)
            fail(Status::argument, "{intervals}: one ends at %lld, another starts at %lld ns TAI: must not overlap",
                 static_cast<long long>(intervals[i - 1].end_ns), static_cast<long long>(intervals[i].start_ns));
}

} // namespace

Predictor::Predictor(const System &system, Observer observer, uint32_t without)
    : system_(system), observer_(std::move(observer)), without_(without), earth_(Earth::shared()) {
    prepare();
}

Predictor::Predictor(const System &system, const Predictor &other)
    : system_(system), observer_(other.observer_), without_(other.without_), earth_(other.earth_) {
    prepare();
}

Predictor::Predictor(const Predictor &other, Observer observer)
    : system_(other.system_), observer_(std::move(observer)), without_(other.without_), earth_(other.earth_) {
    prepare();
}

void Predictor::prepare() noexcept {
    const Barycentre &centre = system_.value.barycentre;
    const double ra = centre.ra_deg * kDegree, dec = centre.dec_deg * kDegree;
    axes_.away = {std::cos(dec) * std::cos(ra), std::cos(dec) * std::sin(ra), std::sin(dec)};
    axes_.east = {-std::sin(ra), std::cos(ra), 0};
    axes_.north = {-std::sin(dec) * std::cos(ra), -std::sin(dec) * std::sin(ra), std::cos(dec)};
    distance_ = 1 / (centre.parallax_mas * 1e-3 * kArcsec);
    motion_ = {};
    if (has(kTransverseMotion)) {
        motion_ = sum(motion_, distance_ * centre.pm_ra_mas_yr * 1e-3 * kArcsec, axes_.east);
        motion_ = sum(motion_, distance_ * centre.pm_dec_mas_yr * 1e-3 * kArcsec, axes_.north);
    }
    if (has(kRadialMotion))
        motion_ = sum(motion_, centre.radial_velocity_km_s * 1e3 / erfa::kLightSpeed * kLightYear, axes_.away);
}

Vector Predictor::barycentre(double year) const noexcept {
    const Vector place = {distance_ * axes_.away[0], distance_ * axes_.away[1], distance_ * axes_.away[2]};
    return sum(place, year - system_.value.barycentre.epoch, motion_);
}

// 0 = A, 1 = B; au from the barycentre of the solar system.
Vector Predictor::star(size_t which, double year) const noexcept {
    const Masses &masses = system_.value.masses;
    const double share = (which == 0 ? -masses.b_sun : masses.a_sun) / (masses.a_sun + masses.b_sun);
    const double au = share / (system_.value.barycentre.parallax_mas * 1e-3); // per arcsec
    const OrbitPosition position = position_on_orbit(system_.value.orbit, year);
    Vector place = barycentre(year);
    place = sum(place, au * position.north_arcsec, axes_.north);
    place = sum(place, au * position.east_arcsec, axes_.east);
    return sum(place, au * position.away_arcsec, axes_.away);
}

// The star whose light is at `from` in this year.
Vector Predictor::seen_star(size_t which, double year, const Vector &from) const noexcept {
    double left = year;
    for (int step = 0; step < kLightTimeSteps; step++)
        left = year - (length(sum(star(which, left), -1, from)) - distance_) / kLightYear;
    return star(which, left);
}

// Star B turned about A by an angle, north through east, in the tangential plane of the orbit.
Vector Predictor::turn(const Vector &a, const Vector &b, double angle) const noexcept {
    const Vector apart = sum(b, -1, a);
    const double north = dot(apart, axes_.north), east = dot(apart, axes_.east);
    const double cosine = std::cos(angle) - 1, sine = std::sin(angle);
    return sum(sum(b, cosine * north - sine * east, axes_.north), cosine * east + sine * north, axes_.east);
}

uint64_t Predictor::digest(bool with_states) const {
    const Barycentre &centre = system_.value.barycentre;
    const Masses &masses = system_.value.masses;
    uint64_t hash = fnv1a(std::array<double, 10>{centre.ra_deg, centre.dec_deg, centre.epoch, centre.pm_ra_mas_yr,
                                                 centre.pm_dec_mas_yr, centre.parallax_mas, centre.radial_velocity_km_s,
                                                 masses.a_sun, masses.b_sun, static_cast<double>(without_)},
                          kFnvOffset);
    for (const auto element : kElementOf)
        hash = fnv1a(std::array<double, 1>{system_.value.orbit.*element}, hash);
    return observer_.digest(hash, with_states);
}

Prediction Predictor::at(int64_t tai_ns) const {
    check_time(tai_ns);
    const double days = terrestrial_days(tai_ns);
    const Earth::State earth = earth_->at(days);
    const State spacecraft = observer_.at(tai_ns);
    const Vector offset = vector_of(spacecraft.position_m, erfa::kAstronomicalUnit);
    const Vector place = sum(earth.earth.from_barycentre, 1, offset);
    const Vector from_sun = sum(earth.earth.from_sun, 1, offset);
    Vector velocity = {}; // in units of the speed of light
    if (has(kEarthAberration))
        velocity = sum(velocity, erfa::kAstronomicalUnit / kSecondsPerDay / erfa::kLightSpeed, earth.earth.velocity);
    if (has(kSpacecraftAberration))
        velocity = sum(velocity, 1, vector_of(spacecraft.velocity_m_s, erfa::kLightSpeed));

    const double year = 2000 + (days + earth.tdb_minus_tt / kSecondsPerDay) / kDaysPerYear;
    const Vector towards = unit(barycentre(year)), nowhere = {};
    const double roemer = has(kRoemer) ? dot(place, towards) / kLightYear : 0, arrival = year + roemer;
    const double distance = length(from_sun);
    const auto direction = [&](const Vector &source) {
        Vector seen = unit(sum(source, has(kParallax) ? -1 : 0, place));
        if (has(kDeflection))
            seen = erfa::deflect_by_sun(seen, unit(from_sun), distance);
        return erfa::aberrate(seen, velocity, distance);
    };
    Vector source[2], seen[2];
    for (size_t which = 0; which < 2; which++) {
        const Vector light_end = has(kRoemer) ? place : nowhere;
        source[which] = has(kLightTime) ? seen_star(which, year, light_end) : star(which, arrival);
        seen[which] = direction(source[which]);
    }

    const OrbitPosition geometric = position_on_orbit(system_.value.orbit, arrival);
    Prediction out = {};
    out.separation_arcsec = erfa::separation(seen[0], seen[1]) / kArcsec;
    out.position_angle_deg = erfa::position_angle(seen[0], seen[1]) / kDegree;
    out.geometric_arcsec = geometric.separation_arcsec();
    out.geometric_angle_deg = geometric.position_angle_deg();
    if (!(out.geometric_arcsec > 0))
        fail(Status::range, "{time} = %lld ns TAI: the stars are at the same position: the factor is not defined",
             static_cast<long long>(tai_ns));
    out.factor = out.separation_arcsec / out.geometric_arcsec;
    const double roemer_s = roemer * kDaysPerYear * kSecondsPerDay;
    out.barycentric_offset_s = static_cast<double>(kTtMinusTaiNs) * 1e-9 + earth.tdb_minus_tt + roemer_s;
    out.approach_m_s = dot(velocity, towards) * erfa::kLightSpeed;
    out.sun_angle_deg = erfa::separation({-from_sun[0], -from_sun[1], -from_sun[2]}, towards) / kDegree;
    const auto change = [&](const Vector &b) { // of the separation, over the factor
        return (erfa::separation(seen[0], direction(b)) / kArcsec - out.separation_arcsec) / out.factor;
    };
    const double au = kFarther / (system_.value.barycentre.parallax_mas * 1e-3);
    const double by_angle = change(turn(source[0], source[1], kTurn)) / kTurn;
    const double by_distance = change(sum(source[1], au, axes_.away)) / kFarther;
    const double by_geometric = 1 - by_distance * geometric.away_arcsec / out.geometric_arcsec;
    const OrbitPartials partials = partials_on_orbit(system_.value.orbit, arrival);
    for (size_t i = 0; i < kElements; i++)
        out.partials[i] =
            by_geometric * partials.separation[i] + by_angle * partials.angle[i] + by_distance * partials.away[i];
    return out;
}

Prediction Predictor::mean(const std::vector<Interval> &intervals) const {
    if (intervals.empty())
        fail(Status::argument, "{intervals}: must not be empty");
    double whole = 0;
    check_disjoint(intervals);
    for (const auto &[start, end] : intervals) {
        if (start == end && intervals.size() == 1)
            return at(start);
        if (!(start < end))
            fail(Status::argument, "{intervals}: start %lld, end %lld ns TAI: must begin before it ends",
                 static_cast<long long>(start), static_cast<long long>(end));
        check_time(start);
        check_time(end);
        if (end - start > kLongestInterval)
            fail(Status::argument, "{intervals}: %.6g days: must be at most 400 days",
                 static_cast<double>(end - start) / static_cast<double>(kNsPerDay));
        if (observer_.ephemeris() != nullptr)
            observer_.ephemeris()->check_interval(start, end);
        whole += static_cast<double>(end - start);
    }
    const Prediction first = at(intervals.front().start_ns);
    Prediction total = {};
    for (const auto &[start, end] : intervals) {
        const auto duration = static_cast<double>(end - start);
        const bool brief = duration <= kShortPanel;
        const Node *const nodes = brief ? kTwoNodes : kFourNodes;
        const size_t count = brief ? std::size(kTwoNodes) : std::size(kFourNodes);
        const double panels = std::ceil(duration / kLongPanel), half = duration / panels / 2;
        for (double panel = 0; panel < panels; panel++)
            for (size_t i = 0; i < count; i++) {
                const double from_start = (2 * panel + 1 + nodes[i].place) * half;
                const double weight = nodes[i].weight * 2 * half / whole;
                accumulate(at(start + std::llround(from_start)), weight, first, total);
            }
    }
    total.position_angle_deg = std::remainder(total.position_angle_deg + first.position_angle_deg, 360);
    total.geometric_angle_deg = std::remainder(total.geometric_angle_deg + first.geometric_angle_deg, 360);
    total.factor = total.separation_arcsec / total.geometric_arcsec;
    return total;
}

void warn_of_centre(const Predictor &predictor, const Log &log) {
    constexpr double kLowOrbitSpeed = 7.56e3; // m/s, at an altitude of 600 km
    constexpr double kWarnedYear = 2030;      // of the separation
    const double arcsec = position_on_orbit(predictor.system().value.orbit, kWarnedYear).separation_arcsec();
    log.warn("no observer given: predictions are for the Earth's centre; the velocity of a spacecraft in a low orbit "
             "changes the separation (%.3g arcsec in %.0f) by up to %.3g uas",
             arcsec, kWarnedYear, 1e6 * arcsec * kLowOrbitSpeed / erfa::kLightSpeed);
}

} // namespace toliman::sky
