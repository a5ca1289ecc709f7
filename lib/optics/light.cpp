// Method: a star's samples are scaled to its flux behind the throughput, then multiplied by the quantum efficiency if
// that depends on the wavelength. The stars' positions follow from separation s and position angle theta (from +y
// towards -x, north through east): B is at s (-sin theta, cos theta) from A.
#include "optics/light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "optics/efficiency.hpp"
#include "optics/spectrum.hpp"
#include "scene/geometry.hpp"

namespace toliman::optics {

namespace {

constexpr double kFarthestDays = 73000; // within the years of the Earth's ephemeris

// Photons of a star per frame, or relative to the other star if the scene gives the peak.
double flux_of(const Scene &scene, const Star &star) {
    if (scene.cadence.exposure_s > 0)
        return *star.photons_per_s * on_target_s(scene.cadence);
    return star.photons_per_s ? *star.photons_per_s : star.relative_flux.value_or(1.0);
}

double sum_of(const std::vector<Sample> &samples) noexcept {
    double sum = 0;
    for (const Sample &sample : samples)
        sum += sample.weight;
    return sum;
}

double total(const std::vector<double> &photons) noexcept {
    return std::accumulate(photons.begin(), photons.end(), 0.0);
}

// Photons to electrons.
void detect(size_t star, Light &light) {
    std::vector<double> &photons = light.photons[star];
    const double before = total(photons);
    for (size_t i = 0; i < photons.size(); i++)
        photons[i] *= light.qe[i];
    light.efficiency[star] = total(photons) / before;
}

void sample_stars(const Scene &scene, Light &light) {
    const Efficiency efficiency(scene);
    std::map<double, std::array<double, 2>> photons; // of both stars by wavelength in nm
    const double share = scene.detector.sidelobe ? scene.detector.sidelobe->efficiency : 1;
    for (size_t star = 0; star < scene.stars.size(); star++) {
        std::vector<Sample> samples = sample_star(scene, star);
        const double before = sum_of(samples);
        for (Sample &sample : samples)
            sample.weight *= efficiency.throughput(sample.wavelength_nm);
        const double sum = sum_of(samples);
        if (!(sum > 0) || !std::isfinite(sum))
            fail(Status::scene, "%s: {stars.%c.spectrum}: the flux in the band is %s", scene.source.c_str(),
                 star == 0 ? 'A' : 'B', sum > 0 ? "infinite" : "0");
        light.throughput[star] = sum / before;
        for (const Sample &sample : samples)
            photons[sample.wavelength_nm][star] += flux_of(scene, scene.stars[star]) * share * (sample.weight / sum);
    }
    for (const auto &[wavelength_nm, both] : photons) {
        light.wavelength_m.push_back(wavelength_nm * 1e-9);
        for (size_t star = 0; star < scene.stars.size(); star++)
            light.photons[star].push_back(both[star]);
        if (!scene.detector.qe_file.empty())
            light.qe.push_back(efficiency.qe(wavelength_nm));
    }
    if (!light.qe.empty())
        for (size_t star = 0; star < scene.stars.size(); star++)
            detect(star, light);
}

// Prediction of the exposure whose middle is `days` after time 0.
sky::Prediction seen_at(const Scene &scene, double days) {
    const Cadence &cadence = scene.cadence;
    if (!(std::fabs(days) < kFarthestDays))
        fail(Status::range, "%s: {time} = %g days: must be within %g days of time 0 with an observer",
             scene.source.c_str(), days, kFarthestDays);
    const int64_t zero = tai_of_date(scene.binary.date);
    std::vector<sky::Interval> intervals = exposure_at(cadence, zero, days);
    if (intervals.empty() && cadence.exposure_s > 0) // without light: the places do not matter
        intervals = whole_exposure_at(cadence, zero, days);
    return intervals.empty() ? scene.binary.sky->at(zero + std::llround(days * 86400e9))
                             : scene.binary.sky->mean(intervals);
}

// Offsets of both stars from their separation and position angle.
Offsets offsets_of(double separation_arcsec, double position_angle_deg, const Scene &scene,
                   const Light &light) noexcept {
    const double angle = (position_angle_deg - scene.detector.rotation_deg) * kPi / 180;
    const double separation = separation_arcsec / scene.detector.pixel_scale_arcsec;
    const double flux_a = photons_before_qe(light, 0), flux_b = photons_before_qe(light, 1);
    double share_a = flux_b / (flux_a + flux_b); // of the separation, from the barycentre of the light to A
    if (scene.binary.centre != Binary::Centre::barycentre)
        share_a = scene.binary.centre == Binary::Centre::a ? 0 : 1;
    const auto from_a_to_b =
        geometry_of(scene.detector).to_pixels(-std::sin(angle) * separation, std::cos(angle) * separation);
    Offsets offsets;
    for (size_t axis = 0; axis < 2; axis++) {
        offsets[0][axis] = -share_a * from_a_to_b[axis];
        offsets[1][axis] = (1 - share_a) * from_a_to_b[axis];
    }
    return offsets;
}

void place_stars(const Scene &scene, Light &light) {
    light.offset_px = orbit_offsets_at(scene, light, 0);
    if (scene.stars.size() < 2)
        return;
    light.separation_px =
        std::hypot(light.offset_px[1][0] - light.offset_px[0][0], light.offset_px[1][1] - light.offset_px[0][1]);
    const auto axis = axis_of(scene, light.offset_px);
    std::copy(axis.begin(), axis.end(), light.axis);
}

// The first order of a grating of period P is where the sine of the angle is lambda/P.
void disperse(const Scene &scene, Light &light) noexcept {
    if (!scene.detector.sidelobe)
        return;
    const Sidelobe &sidelobe = *scene.detector.sidelobe;
    const double angle = sidelobe.angle_deg * kPi / 180,
                 per_m = 1 / (sidelobe.period_m * scene.detector.pixel_scale_arcsec * kPi / 648000);
    const auto px = geometry_of(scene.detector).to_pixels(std::cos(angle) * per_m, std::sin(angle) * per_m);
    std::copy(px.begin(), px.end(), light.dispersion);
    light.centre_m = sidelobe.centre_m;
}

} // namespace

Light make_light(const Scene &scene) {
    Light light;
    sample_stars(scene, light);
    place_stars(scene, light);
    disperse(scene, light);
    return light;
}

double photons_before_qe(const Light &light, size_t star) noexcept {
    return total(light.photons[star]) / light.efficiency[star];
}

std::array<double, 2> axis_of(const Scene &scene, const Offsets &offsets) noexcept {
    if (scene.stars.size() < 2)
        return {1, 0};
    const double x = offsets[1][0] - offsets[0][0], y = offsets[1][1] - offsets[0][1];
    const double length = (scene.signal.star == 0 ? -1 : 1) * std::hypot(x, y); // away from the other star
    return {x / length, y / length};
}

Offsets orbit_offsets_at(const Scene &scene, const Light &light, double days) noexcept {
    const Binary &binary = scene.binary;
    if (scene.stars.size() < 2 || binary.by_offsets) {
        const double *offset = binary.offsets_px;
        return {{{offset[0], offset[1]}, {offset[2], offset[3]}}};
    }
    if (!binary.orbit)
        return offsets_of(binary.separation_arcsec, binary.position_angle_deg, scene, light);
    const sky::OrbitPosition at = sky::position_on_orbit(*binary.orbit, binary.date + days / sky::kDaysPerYear);
    return offsets_of(at.separation_arcsec(), at.position_angle_deg(), scene, light);
}

Offsets unobserved_offsets_at(const Scene &scene, const Light &light, double days) noexcept {
    return scene.binary.moving ? orbit_offsets_at(scene, light, days) : light.offset_px;
}

Offsets offsets_at(const Scene &scene, const Light &light, double days) {
    if (!scene.binary.moving || scene.binary.sky == nullptr)
        return unobserved_offsets_at(scene, light, days);
    const sky::Prediction seen = seen_at(scene, days);
    return offsets_of(seen.separation_arcsec, seen.position_angle_deg, scene, light);
}

double relative_light_at(const Scene &scene, double days) {
    const Cadence &cadence = scene.cadence;
    if (cadence.windows.empty())
        return 1;
    return seconds_of(exposure_at(cadence, tai_of_date(scene.binary.date), days)) / on_target_s(cadence);
}

void scale_light(Light &light, double factor) noexcept {
    for (std::vector<double> &photons : light.photons)
        for (double &value : photons)
            value *= factor;
}

} // namespace toliman::optics
