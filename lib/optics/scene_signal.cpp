#include "base/constants.hpp"
#include "optics/scene_groups.hpp"
#include "optics/wobble.hpp"

namespace toliman::optics {

namespace {

void read_planet(const Reader &reader, const Scene &known, Signal &signal) {
    reader.exclude({"amplitude_px", "amplitude_uas", "period_days"},
                   "needs kind \"sinusoid\"; for a planet mass_earth and semi_major_au determine it");
    reader.allow({"kind", "star", "mass_earth", "semi_major_au", "eccentricity", "argument_deg", "phase_rad"});
    const char star = kStarNames[signal.star][0];
    if (!known.stars[signal.star].mass_sun)
        reader.refuse(Status::scene, "kind", " = \"planet\": needs stars.%c.mass_sun", star);
    if (!known.binary.distance_pc)
        reader.refuse(Status::scene, "kind", " = \"planet\": needs binary.distance_pc");
    const Planet planet = {reader.number("mass_earth", within(0, 1e6, "Earth masses")),
                           reader.number("semi_major_au", within(1e-6, 1e4, "au")), *known.stars[signal.star].mass_sun,
                           *known.binary.distance_pc};
    signal.amplitude_px = reflex_uas(planet) / (1e6 * known.detector.pixel_scale_arcsec);
    signal.period_days = period_days(planet);
    signal.eccentricity = reader.number_or("eccentricity", 0, kEccentricity);
    signal.argument_rad = reader.number_or("argument_deg", 0, kTurn) * kPi / 180;
    const double farthest = signal.amplitude_px * (1 + signal.eccentricity);
    if (farthest > kFarthestDisplacement)
        reader.refuse(Status::scene, "mass_earth", " = %g: moves star %c by up to %.3g px: must be at most %g px",
                      planet.mass_earth, star, farthest, kFarthestDisplacement);
}

void read_sinusoid(const Reader &reader, const Scene &known, Signal &signal) {
    reader.exclude({"mass_earth", "semi_major_au", "eccentricity", "argument_deg"}, "needs kind \"planet\"");
    reader.allow({"kind", "star", "amplitude_px", "amplitude_uas", "period_days", "phase_rad"});
    if (reader.has("amplitude_px") == reader.has("amplitude_uas"))
        reader.refuse(Status::scene, "amplitude_px", ": give either amplitude_px or amplitude_uas");
    if (reader.has("amplitude_px")) {
        signal.amplitude_px = reader.number("amplitude_px", within(0, kFarthestDisplacement, "px"));
    } else {
        const double microarcsec_per_px = known.detector.pixel_scale_arcsec * 1e6;
        const Range range = within(0, kFarthestDisplacement * microarcsec_per_px, "uas");
        signal.amplitude_px = reader.number("amplitude_uas", range) / microarcsec_per_px;
    }
    signal.period_days = reader.number("period_days", within(1e-6, 1e9, "days"));
}

} // namespace

Signal read_signal(const Reader &scene, const Scene &known) {
    Signal signal;
    if (!scene.has("signal"))
        return signal;
    const Reader reader = scene.object("signal");
    const size_t kind = reader.choice("kind", {"none", "sinusoid", "planet"});
    if (kind == 0) {
        reader.exclude({"star", "phase_rad"}, "needs a signal: kind \"sinusoid\" or \"planet\"");
        reader.exclude({"amplitude_px", "amplitude_uas", "period_days"}, "needs kind \"sinusoid\"");
        reader.exclude({"mass_earth", "semi_major_au", "eccentricity", "argument_deg"}, "needs kind \"planet\"");
        reader.allow({"kind"});
        return signal;
    }
    if (reader.has("star"))
        signal.star = reader.choice("star", {"A", "B"});
    if (signal.star >= known.stars.size())
        reader.refuse(Status::scene, "star", " = \"B\": the scene has star A only");
    if (kind == 1)
        read_sinusoid(reader, known, signal);
    else
        read_planet(reader, known, signal);
    signal.phase_rad = reader.number_or("phase_rad", 0, within(-1e3, 1e3, "rad"));
    return signal;
}

} // namespace toliman::optics
