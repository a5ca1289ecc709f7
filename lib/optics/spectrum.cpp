// Method: spectra are photon counts (not energies) at uniform steps with trapezium weights, half at both ends. With
// full weights at the ends a sum in 1 nm steps differs from the integral by 1.7e-2 of the peak.
#include "optics/spectrum.hpp"

#include "base/error.hpp"
#include "kernels/blackbody.hpp"
#include "scene/instrument.hpp"

namespace toliman::optics {

namespace {

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

// x = -1 ... 1 over the band.
double in_band(const Scene &scene, double wavelength_nm) noexcept {
    const Band &band = *scene.band;
    return (2 * wavelength_nm - band.min_nm - band.max_nm) / (band.max_nm - band.min_nm);
}

std::vector<Sample> sample_lines(const Spectrum &spectrum) {
    std::vector<Sample> samples;
    for (size_t i = 0; i < spectrum.weight.size(); i++)
        samples.push_back({spectrum.wavelength_nm[i], spectrum.weight[i]});
    return samples;
}

void check_band(const Scene &scene, const Spectrum &spectrum, const SpectrumTable &table) {
    if (!table.covers(scene.band->min_nm, scene.band->max_nm))
        fail(Status::scene, "%s: {band}: %g to %g nm: must be within the range of %s, %g to %g nm",
             scene.source.c_str(), scene.band->min_nm, scene.band->max_nm, spectrum.file.c_str(), table.first_nm(),
             table.last_nm());
}

} // namespace

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

Continuum::Continuum(const Spectrum &spectrum) : spectrum_(spectrum) {
    if (spectrum.kind == Spectrum::Kind::table)
        table_.emplace(spectrum.file);
}

double Continuum::at(double wavelength_nm) const noexcept {
    const double wavelength_m = wavelength_nm * 1e-9;
    if (!table_)
        return kernels::blackbody_photons(wavelength_m, spectrum_.temperature_k);
    const double photons = table_->at(wavelength_nm);
    if (spectrum_.star_temperature_k == spectrum_.table_temperature_k)
        return photons;
    return photons * (kernels::blackbody_photons(wavelength_m, spectrum_.star_temperature_k) /
                      kernels::blackbody_photons(wavelength_m, spectrum_.table_temperature_k));
}

std::vector<Sample> sample_star(const Scene &scene, size_t star) {
    const Spectrum &spectrum = scene.stars[star].spectrum;
    if (spectrum.kind == Spectrum::Kind::lines)
        return sample_lines(spectrum);
    const Continuum continuum(spectrum);
    if (continuum.table())
        check_band(scene, spectrum, *continuum.table());
    std::vector<Sample> samples = sample_band(*scene.band);
    for (Sample &sample : samples)
        sample.weight *= continuum.at(sample.wavelength_nm);
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

double temperature_rate(const Scene &scene, size_t star, double wavelength_m) noexcept {
    return kernels::blackbody_rate(wavelength_m, temperature_of(scene, star));
}

double mode_rate(const Scene &scene, size_t star, int number, double wavelength_m) {
    const double x = in_band(scene, wavelength_m * 1e9);
    std::vector<double> single(static_cast<size_t>(number), 0.0);
    single.back() = 1;
    return (mode_factor(single, x) - 1) / mode_factor(scene.stars[star].spectrum.modes, x);
}

} // namespace toliman::optics
