#include <algorithm>
#include <cmath>

#include "optics/scene_groups.hpp"

namespace toliman::optics {

namespace {

constexpr Range kWavelength = within(1, 1e6, "nm");
constexpr double kMostSteps = 4096;

Source read_source(const Reader &star, const std::string &folder) {
    const Reader reader = star.object("spectrum");
    Source source;
    source.kind = static_cast<Source::Kind>(reader.choice("kind", {"blackbody", "table", "lines"}));
    if (source.kind != Source::Kind::blackbody)
        reader.exclude({"temperature_k"}, "needs kind \"blackbody\"");
    if (source.kind != Source::Kind::table)
        reader.exclude({"file"}, "needs kind \"table\"");
    if (source.kind != Source::Kind::lines)
        reader.exclude({"wavelength_nm", "weight"}, "needs kind \"lines\"");
    switch (source.kind) {
    case Source::Kind::blackbody:
        reader.allow({"kind", "temperature_k"});
        source.temperature_k = reader.number("temperature_k", within(100, 1e6, "K"));
        break;
    case Source::Kind::table:
        reader.allow({"kind", "file"});
        source.file = reader.file("file", folder);
        break;
    case Source::Kind::lines:
        reader.allow({"kind", "wavelength_nm", "weight"});
        source.wavelength_nm = reader.numbers("wavelength_nm", 1, 1024, kWavelength);
        source.weight = reader.numbers("weight", 1, 1024, within(0, 1e30, ""));
        if (source.weight.size() != source.wavelength_nm.size())
            reader.refuse(Status::scene, "weight", ": has %zu numbers: must have %zu, one per spectral line",
                          source.weight.size(), source.wavelength_nm.size());
        if (std::none_of(source.weight.begin(), source.weight.end(), [](double weight) { return weight > 0; }))
            reader.refuse(Status::scene, "weight", ": all are 0: at least one must be above 0");
        break;
    }
    return source;
}

} // namespace

std::optional<Band> read_band(const Reader &scene) {
    if (!scene.has("band"))
        return std::nullopt;
    const Reader reader = scene.object("band");
    Band band;
    if (reader.has("wavelength_nm")) {
        reader.exclude({"min_nm", "max_nm", "step_nm"},
                       "not allowed with wavelength_nm, which gives a single wavelength");
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
        reader.refuse(Status::scene, "step_nm", " = %g: gives %.0f steps: must be at most %.0f", step_nm, steps,
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
        entry.allow({"spectrum", "relative_flux", "photons_per_s", "mass_sun"});
        Star star;
        star.source = read_source(entry, folder);
        star.relative_flux = entry.optional_number("relative_flux", above(0, 1e12, ""));
        star.photons_per_s = entry.optional_number("photons_per_s", above(0, 1e15, "photons/s"));
        if (star.relative_flux && star.photons_per_s)
            entry.refuse(Status::scene, "relative_flux", ": give either relative_flux or photons_per_s");
        star.mass_sun = entry.optional_number("mass_sun", above(0, 1e3, "solar masses"));
        stars.push_back(star);
    }
    return stars;
}

} // namespace toliman::optics
