#include <algorithm>
#include <cmath>

#include "optics/scene_groups.hpp"

namespace toliman::optics {

namespace {

constexpr const char *kStarNames[] = {"A", "B"};
constexpr Range kWavelength = within(1, 1e6, "nm");
constexpr double kMostSteps = 4096;

Source read_source(const Reader &star, const std::string &folder) {
    const Reader reader = star.object("spectrum");
    Source source;
    source.kind = static_cast<Source::Kind>(reader.choice("kind", {"blackbody", "table", "lines"}));
    switch (source.kind) {
    case Source::Kind::blackbody:
        reader.allow({"kind", "temperature_k"});
        source.temperature_k = reader.number("temperature_k", within(100, 1e6, "K"));
        break;
    case Source::Kind::table:
        reader.allow({"kind", "file"});
        source.file = resolve(folder, reader.text("file"));
        break;
    case Source::Kind::lines:
        reader.allow({"kind", "wavelength_nm", "weight"});
        source.wavelength_nm = reader.numbers("wavelength_nm", 1, 1024, kWavelength);
        source.weight = reader.numbers("weight", 1, 1024, within(0, 1e30, ""));
        if (source.weight.size() != source.wavelength_nm.size())
            reader.refuse(Status::scene, "weight", ": %zu numbers: must be one a line, %zu", source.weight.size(),
                          source.wavelength_nm.size());
        if (std::none_of(source.weight.begin(), source.weight.end(), [](double weight) { return weight > 0; }))
            reader.refuse(Status::scene, "weight", ": all 0: at least one line must shine");
        break;
    }
    return source;
}

std::vector<double> read_offset(const Reader &offsets, const char *star) {
    return offsets.numbers(star, 2, 2, within(-1e4, 1e4, "px"));
}

void read_offsets(const Reader &binary, size_t stars, Binary &result) {
    binary.allow({"offsets_px"});
    const Reader reader = binary.object("offsets_px");
    if (stars == 2)
        reader.allow({"A", "B"});
    else
        reader.allow({"A"});
    result.by_offsets = true;
    for (size_t star = 0; star < stars; star++) {
        const std::vector<double> offset = read_offset(reader, kStarNames[star]);
        std::copy(offset.begin(), offset.end(), result.offsets_px + 2 * star);
    }
    const double *offset = result.offsets_px;
    if (stars == 2 && std::equal(offset, offset + 2, offset + 2))
        binary.refuse(Status::scene, "offsets_px", ": both stars stand at (%g, %g): the separation has no direction",
                      offset[0], offset[1]);
}

} // namespace

std::optional<Band> read_band(const Reader &scene) {
    if (!scene.has("band"))
        return std::nullopt;
    const Reader reader = scene.object("band");
    Band band;
    if (reader.has("wavelength_nm")) {
        reader.allow({"wavelength_nm"});
        band.min_nm = band.max_nm = reader.number("wavelength_nm", kWavelength);
        return band;
    }
    reader.allow({"min_nm", "max_nm", "step_nm", "wavelength_nm"});
    band.min_nm = reader.number("min_nm", kWavelength);
    band.max_nm = reader.number("max_nm", kWavelength);
    const double step_nm = reader.number("step_nm", above(0, 1e6, "nm"));
    if (band.max_nm <= band.min_nm)
        reader.refuse(Status::scene, "max_nm", " = %g: must be above min_nm = %g nm", band.max_nm, band.min_nm);
    const double steps = std::round((band.max_nm - band.min_nm) / step_nm);
    if (steps < 1 || std::fabs(steps * step_nm - (band.max_nm - band.min_nm)) > 1e-6 * step_nm)
        reader.refuse(Status::scene, "step_nm", " = %g: must divide the band of %g nm into equal steps", step_nm,
                      band.max_nm - band.min_nm);
    if (steps > kMostSteps)
        reader.refuse(Status::scene, "step_nm", " = %g: %.0f steps: at most %.0f are allowed", step_nm, steps,
                      kMostSteps);
    band.steps = static_cast<size_t>(steps);
    return band;
}

std::vector<Star> read_stars(const Reader &scene, const std::string &folder) {
    const Reader reader = scene.object("stars");
    reader.allow({"A", "B"});
    std::vector<Star> stars;
    for (const char *name : kStarNames) {
        if (!reader.has(name) && !stars.empty())
            break;
        const Reader entry = reader.object(name);
        entry.allow({"spectrum", "relative_flux", "photons_per_s"}, {"mass_sun", "distance_pc"});
        Star star;
        star.source = read_source(entry, folder);
        star.relative_flux = entry.optional_number("relative_flux", above(0, 1e12, ""));
        star.photons_per_s = entry.optional_number("photons_per_s", above(0, 1e15, "photons/s"));
        if (star.relative_flux && star.photons_per_s)
            entry.refuse(Status::scene, "relative_flux", ": give either relative_flux or photons_per_s");
        stars.push_back(star);
    }
    return stars;
}

Binary read_binary(const Reader &scene, size_t stars) {
    Binary binary;
    if (!scene.has("binary")) {
        if (stars == 2)
            scene.refuse(Status::scene, "binary", ": is missing: two stars need their places");
        return binary;
    }
    const Reader reader = scene.object("binary");
    if (reader.has("offsets_px")) {
        read_offsets(reader, stars, binary);
        return binary;
    }
    reader.allow({"separation_arcsec", "position_angle_deg", "centre", "offsets_px"}, {"date", "orbit", "distance_pc"});
    if (stars == 1)
        scene.refuse(Status::scene, "binary", ": a single star takes offsets_px only");
    binary.separation_arcsec = reader.number("separation_arcsec", within(1e-6, 1e5, "arcsec"));
    binary.position_angle_deg = reader.number_or("position_angle_deg", 0, within(-360, 360, "deg"));
    if (reader.has("centre"))
        binary.centre = static_cast<Binary::Centre>(reader.choice("centre", {"barycentre", "A", "B"}));
    return binary;
}

Signal read_signal(const Reader &scene, size_t stars, double pixel_scale_arcsec) {
    Signal signal;
    if (!scene.has("signal"))
        return signal;
    const Reader reader = scene.object("signal");
    reader.choice("kind", {"sinusoid"}, {"planet"});
    reader.allow({"kind", "star", "amplitude_px", "amplitude_uas", "period_days", "phase_rad"});
    if (reader.has("star"))
        signal.star = reader.choice("star", {"A", "B"});
    if (signal.star >= stars)
        reader.refuse(Status::scene, "star", " = \"B\": the scene has star A only");
    if (reader.has("amplitude_px") == reader.has("amplitude_uas"))
        reader.refuse(Status::scene, "amplitude_px", ": give either amplitude_px or amplitude_uas");
    if (reader.has("amplitude_px")) {
        signal.amplitude_px = reader.number("amplitude_px", within(0, kLargestDisplacement, "px"));
    } else {
        const double microarcsec_per_px = pixel_scale_arcsec * 1e6;
        const Range range = within(0, kLargestDisplacement * microarcsec_per_px, "uas");
        signal.amplitude_px = reader.number("amplitude_uas", range) / microarcsec_per_px;
    }
    signal.period_days = reader.number("period_days", above(0, 1e9, "days"));
    signal.phase_rad = reader.number_or("phase_rad", 0, within(-1e3, 1e3, "rad"));
    return signal;
}

} // namespace toliman::optics
