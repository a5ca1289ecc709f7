#include "scene/geometry.hpp"
#include "scene/groups.hpp"

namespace toliman::scene {

namespace {

constexpr Condition kIsSinusoid =
    is("kind", "sinusoid", "needs kind \"sinusoid\"; for a planet mass_earth and semi_major_au determine it");
constexpr Condition kIsPlanet = is("kind", "planet");
constexpr Condition kMoves = is("kind", "sinusoid planet", "needs a signal: kind \"sinusoid\" or \"planet\"");

void check_star(const Reader &reader, const Signal &signal) {
    if (signal.star >= reader.scene().stars.size())
        reader.refuse(Status::scene, "star", " = \"B\": the scene has star A only");
}

void read_microarcsec(const Reader &reader, const Row &row, Signal &signal) {
    const Scene &scene = reader.scene();
    const double microarcsec_per_px = scene.detector.pixel_scale_arcsec * 1e6 / pixels_along_axis(scene);
    const Range range = within(0, kFarthestDisplacement * microarcsec_per_px, row.range.unit);
    signal.amplitude_px = reader.number(row.key, range) / microarcsec_per_px;
}

constexpr Row kSignalRows[] = {
    required<&Signal::kind>("kind", Words{"none sinusoid planet"},
                            "none; sinusoid: amplitude sin(2 pi t / period + phase); planet: reflex motion of its "
                            "star, a m/(M + m) r/a sin(true anomaly + argument) on the sky, at most 100 px, which "
                            "needs the star's mass_sun and the binary's distance_pc"),
    optional<&Signal::star>("star", Words{"A B"}, "The star that moves").when(kMoves).checked<check_star>(),
    required<&Signal::amplitude_px>("amplitude_px", within(0, kFarthestDisplacement, "px"), "Amplitude")
        .either("amplitude_uas")
        .when(kIsSinusoid),
    optional<read_microarcsec>("amplitude_uas", within(0, kUnlimited, "uas"),
                               "Amplitude in microarcsec; at most 100 px")
        .when(kIsSinusoid),
    required<&Signal::period_days>("period_days", within(1e-6, 1e9, "days"), "Period").when(kIsSinusoid),
    required<&Signal::mass_earth>("mass_earth", within(0, 1e6, "Earth masses"), "Mass of the planet").when(kIsPlanet),
    required<&Signal::semi_major_au>("semi_major_au", within(1e-6, 1e4, "au"),
                                     "Semi-major axis of the planet about its star; gives the period, 365.2569 days "
                                     "for 1 au about 1 solar mass")
        .when(kIsPlanet),
    optional<&Signal::eccentricity>("eccentricity", kEccentricity, "Eccentricity").when(kIsPlanet),
    optional<&Signal::argument_deg>("argument_deg", kTurn,
                                    "Argument of the periastron of the star, from the perpendicular of the axis "
                                    "towards positive displacement; 0: the star passes periastron where the "
                                    "displacement is 0 and grows")
        .when(kIsPlanet),
    optional<&Signal::phase_rad>("phase_rad", within(-1e3, 1e3, "rad"),
                                 "Phase at time 0; of a planet its mean anomaly at time 0")
        .when(kMoves),
};

} // namespace

constexpr Group kSignal =
    group_of("signal",
             "Motion of one star along the binary's axis (+x for a single star); positive lengthens the "
             "separation",
             kSignalRows);

} // namespace toliman::scene
