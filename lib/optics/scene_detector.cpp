#include <cmath>

#include "base/constants.hpp"
#include "optics/scene_groups.hpp"

namespace toliman::optics {

namespace {

// A number is the rms; an object gives rms and drift. `most` bounds the rms and the total drift over the cadence.
Disturbance read_disturbance(const Reader &reader, const char *key, double most, const char *unit, double days) {
    Disturbance disturbance;
    if (!reader.has_object(key)) {
        disturbance.rms = reader.number_or(key, 0, within(0, most, unit));
        return disturbance;
    }
    const Reader object = reader.object(key);
    object.allow({"rms", "drift_per_day"});
    disturbance.rms = object.number("rms", within(0, most, unit));
    disturbance.drift_per_day = object.number_or("drift_per_day", 0, within(-most, most, unit));
    const double drift = std::fabs(disturbance.drift_per_day) * days;
    if (drift > most)
        object.refuse(Status::scene, "drift_per_day",
                      " = %g: amounts to %g in the cadence's %g days: must be at most %g%s%s",
                      disturbance.drift_per_day, drift, days, most, unit[0] != '\0' ? " " : "", unit);
    return disturbance;
}

Disturbance scaled(Disturbance disturbance, double factor) noexcept {
    return {disturbance.rms * factor, disturbance.drift_per_day * factor};
}

} // namespace

Detector read_detector(const Reader &scene, const Cadence &cadence) {
    const Reader reader = scene.object("detector");
    reader.allow({"shape", "pixel_scale_arcsec", "pixel", "rotation_deg", "qe", "coadds", "flat_rms", "dark_e_per_s",
                  "full_well_e", "gain_e_per_dn", "bias_dn", "bit_depth"},
                 {"bin"});
    const std::vector<double> shape = reader.numbers("shape", 2, 2, within(1, 2048, "px"));
    if (shape[0] != std::floor(shape[0]) || shape[1] != std::floor(shape[1]))
        reader.refuse(Status::scene, "shape", " = [%g, %g]: must be whole numbers", shape[0], shape[1]);
    Detector detector;
    detector.rows = static_cast<size_t>(shape[0]);
    detector.cols = static_cast<size_t>(shape[1]);
    detector.pixel_scale_arcsec = reader.number("pixel_scale_arcsec", within(1e-6, 100, "arcsec"));
    if (reader.has("pixel"))
        detector.integrated = reader.choice("pixel", {"point", "integrated"}) == 1;
    detector.rotation_deg = reader.number_or("rotation_deg", 0, within(-360, 360, "deg"));
    detector.qe = reader.number_or("qe", 1, above(0, 1, ""));
    if (reader.has("coadds"))
        detector.coadds = reader.integer("coadds", within(1, 1e9, "frames"));
    detector.flat_rms = reader.number_or("flat_rms", 0, within(0, 0.1, "")); // keeps responses above 0
    detector.dark_e_per_s = reader.number_or("dark_e_per_s", 0, within(0, 1e9, "e-/s"));
    if (detector.dark_e_per_s > 0 && cadence.exposure_s == 0)
        reader.refuse(Status::scene, "dark_e_per_s", " = %g: needs cadence.exposure_s", detector.dark_e_per_s);
    detector.full_well_e = reader.optional_number("full_well_e", within(1, 1e12, "e-"));
    detector.gain_e_per_dn = reader.number_or("gain_e_per_dn", 1, within(1e-6, 1e12, "e- per DN"));
    detector.bias_dn = reader.number_or("bias_dn", 0, within(0, 4294967295, "DN"));
    if (reader.has("bit_depth"))
        detector.bit_depth = static_cast<int>(reader.integer("bit_depth", within(1, 32, "bits")));
    return detector;
}

Systematics read_systematics(const Reader &scene, const Cadence &cadence) {
    Systematics systematics;
    if (!scene.has("systematics"))
        return systematics;
    const Reader reader = scene.object("systematics");
    reader.allow({"pointing_rms_px", "jitter_sigma_px", "roll_rms_deg", "scale_rms", "focus_rms_nm", "flux_rms"});
    const double days = longest_days(cadence);
    systematics.pointing_px = read_disturbance(reader, "pointing_rms_px", 10, "px", days);
    systematics.roll_rad = scaled(read_disturbance(reader, "roll_rms_deg", 10, "deg", days), kPi / 180);
    systematics.scale = read_disturbance(reader, "scale_rms", 0.01, "", days);
    systematics.focus_nm = read_disturbance(reader, "focus_rms_nm", 1000, "nm", days);
    systematics.flux = read_disturbance(reader, "flux_rms", 0.1, "", days);
    const Disturbance jitter = read_disturbance(reader, "jitter_sigma_px", 10, "px", days);
    if (jitter.drift_per_day != 0)
        reader.refuse(Status::unsupported, "jitter_sigma_px",
                      ".drift_per_day = %g: must be 0: the blur is the same in all frames", jitter.drift_per_day);
    systematics.jitter_px = jitter.rms;
    return systematics;
}

} // namespace toliman::optics
