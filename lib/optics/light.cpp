// Method: spectra are photon counts (not energies) at uniform steps with trapezium weights, half at both ends. With
// full weights at the ends a sum in 1 nm steps differs from the integral by 1.7e-2 of the peak. The stars' positions
// follow from separation s and position angle theta (from +y towards -x, north through east): B is at s (-sin theta,
// cos theta) from A.
#include "optics/light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "base/constants.hpp"
#include "base/error.hpp"
#include "kernels/blackbody.hpp"
#include "scene/geometry.hpp"
#include "scene/instrument.hpp"
#include "scene/spectrum_table.hpp"

namespace toliman::optics {

namespace {

constexpr double kFarthestDays = 73000; // within the years of the Earth's ephemeris

struct Sample {
    double wavelength_nm, weight;
};

// The band's wavelengths with trapezium weights.
std::vector<Sample> sample_band(const Band &band) {
    if (band.steps == 0)
        return {{band.min_nm, 1}};
    std::vector<Sample> samples;
    const auto steps = static_cast<double>(band.steps);
    for (size_t i = 0; i <= band.steps; i++)
        samples.push_back({band.min_nm + (band.max_nm - band.min_nm) * (static_cast<double>(i) / steps),
                           i == 0 || i == band.steps ? 0.5 : 1.0});
    samples.back().wavelength_nm = band.max_nm; // the sum may round above it
    return samples;
}

std::vector<Sample> sample_table(const Scene &scene, const Spectrum &spectrum) {
    const SpectrumTable table(spectrum.file);
    if (table.first_nm() > scene.band->min_nm || table.last_nm() < scene.band->max_nm)
        fail(Status::scene, "%s: {band}: %g to %g nm: must be within the range of %s, %g to %g nm",
             scene.source.c_str(), scene.band->min_nm, scene.band->max_nm, spectrum.file.c_str(), table.first_nm(),
             table.last_nm());
    std::vector<Sample> samples = sample_band(*scene.band);
    for (Sample &sample : samples)
        sample.weight *= table.at(sample.wavelength_nm);
    return samples;
}

constexpr double kSmallestFactor = 1e-6; // of spectral modes; their derivative divides by it

// 1 + sum over k of modes[k - 1] P_k(x), by the recurrence k P_k = (2 k - 1) x P_(k-1) - (k - 1) P_(k-2).
double mode_factor(const std::vector<double> &modes, double x) noexcept {
    double factor = 1, last = 0, polynomial = 1;
    for (size_t i = 0; i < modes.size(); i++) {
        const auto k = static_cast<double>(i + 1);
        const double next = ((2 * k - 1) * x * polynomial - (k - 1) * last) / k;
        last = polynomial;
        polynomial = next;
        factor += modes[i] * polynomial;
    }
    return factor;
}

std::vector<Sample> sample_spectrum(const Scene &scene, const Spectrum &spectrum) {
    std::vector<Sample> samples;
    switch (spectrum.kind) {
    case Spectrum::Kind::blackbody:
        samples = sample_band(*scene.band);
        for (Sample &sample : samples)
            sample.weight *= kernels::blackbody_photons(sample.wavelength_nm * 1e-9, spectrum.temperature_k);
        break;
    case Spectrum::Kind::table:
        samples = sample_table(scene, spectrum);
        break;
    case Spectrum::Kind::lines:
        for (size_t i = 0; i < spectrum.weight.size(); i++)
            samples.push_back({spectrum.wavelength_nm[i], spectrum.weight[i]});
        break;
    }
    return samples;
}

// x = -1 ... 1 over the band.
double in_band(const Scene &scene, double wavelength_nm) noexcept {
    const Band &band = *scene.band;
    return (2 * wavelength_nm - band.min_nm - band.max_nm) / (band.max_nm - band.min_nm);
}

// The star's spectrum with its deviations: its temperature, and modes.
std::vector<Sample> sample_star(const Scene &scene, size_t star) {
    const Spectrum &spectrum = scene.stars[star].spectrum;
    std::vector<Sample> samples = sample_spectrum(scene, spectrum);
    if (spectrum.star_temperature_k != spectrum.table_temperature_k)
        for (Sample &sample : samples)
            sample.weight *= kernels::blackbody_photons(sample.wavelength_nm * 1e-9, spectrum.star_temperature_k) /
                             kernels::blackbody_photons(sample.wavelength_nm * 1e-9, spectrum.table_temperature_k);
    if (spectrum.modes.empty())
        return samples;
    for (Sample &sample : samples) {
        const double factor = mode_factor(spectrum.modes, in_band(scene, sample.wavelength_nm));
        if (!(factor >= kSmallestFactor))
            fail(Status::scene,
                 "%s: {stars.%c.spectrum.modes}: multiply the spectrum by %g at %g nm: must be at least 1e-6",
                 scene.source.c_str(), star == 0 ? 'A' : 'B', factor, sample.wavelength_nm);
        sample.weight *= factor;
    }
    return samples;
}

// Photons of a star per frame, or relative to the other star if the scene gives the peak.
double flux_of(const Scene &scene, const Star &star) {
    if (scene.cadence.exposure_s > 0)
        return *star.photons_per_s * on_target_s(scene.cadence);
    return star.photons_per_s ? *star.photons_per_s : star.relative_flux.value_or(1.0);
}

void sample_stars(const Scene &scene, Light &light) {
    std::map<double, std::array<double, 2>> photons; // of both stars by wavelength in nm
    for (size_t star = 0; star < scene.stars.size(); star++) {
        const std::vector<Sample> samples = sample_star(scene, star);
        double sum = 0;
        for (const Sample &sample : samples)
            sum += sample.weight;
        if (!(sum > 0) || !std::isfinite(sum))
            fail(Status::scene, "%s: {stars.%c.spectrum}: the flux in the band is %s", scene.source.c_str(),
                 star == 0 ? 'A' : 'B', sum > 0 ? "infinite" : "0");
        for (const Sample &sample : samples)
            photons[sample.wavelength_nm][star] += flux_of(scene, scene.stars[star]) * (sample.weight / sum);
    }
    for (const auto &[wavelength_nm, both] : photons) {
        light.wavelength_m.push_back(wavelength_nm * 1e-9);
        for (size_t star = 0; star < scene.stars.size(); star++)
            light.photons[star].push_back(both[star]);
    }
}

double total(const std::vector<double> &photons) noexcept {
    return std::accumulate(photons.begin(), photons.end(), 0.0);
}

// Prediction of the exposure whose middle is `days` after time 0.
sky::Prediction seen_at(const Scene &scene, double days) {
    const Cadence &cadence = scene.cadence;
    if (!(std::fabs(days) < kFarthestDays))
        fail(Status::range, "%s: {time} = %g days: must be within %g days of time 0 with an observer",
             scene.source.c_str(), days, kFarthestDays);
    const double half_s = cadence.exposure_s / 2;
    const int64_t middle = tai_of_date(scene.binary.date) + std::llround(days * 86400e9);
    std::vector<sky::Interval> intervals;
    for (size_t i = 0; i + 1 < cadence.on_target_s.size(); i += 2)
        intervals.push_back({middle + std::llround((cadence.on_target_s[i] - half_s) * 1e9),
                             middle + std::llround((cadence.on_target_s[i + 1] - half_s) * 1e9)});
    if (intervals.empty() && half_s > 0)
        intervals.push_back({middle - std::llround(half_s * 1e9), middle + std::llround(half_s * 1e9)});
    return intervals.empty() ? scene.binary.sky->at(middle) : scene.binary.sky->mean(intervals);
}

// Offsets of both stars from their separation and position angle.
Offsets offsets_of(double separation_arcsec, double position_angle_deg, const Scene &scene,
                   const Light &light) noexcept {
    const double angle = (position_angle_deg - scene.detector.rotation_deg) * kPi / 180;
    const double separation = separation_arcsec / scene.detector.pixel_scale_arcsec;
    const double flux_a = total(light.photons[0]), flux_b = total(light.photons[1]);
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

} // namespace

double temperature_rate(const Scene &scene, size_t star, double wavelength_m) noexcept {
    return kernels::blackbody_rate(wavelength_m, temperature_of(scene, star));
}

double mode_rate(const Scene &scene, size_t star, int number, double wavelength_m) {
    const double x = in_band(scene, wavelength_m * 1e9);
    std::vector<double> single(static_cast<size_t>(number), 0.0);
    single.back() = 1;
    return (mode_factor(single, x) - 1) / mode_factor(scene.stars[star].spectrum.modes, x);
}

Light make_light(const Scene &scene) {
    Light light;
    sample_stars(scene, light);
    place_stars(scene, light);
    return light;
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

void scale_light(Light &light, double factor) noexcept {
    for (std::vector<double> &photons : light.photons)
        for (double &value : photons)
            value *= factor;
}

} // namespace toliman::optics
