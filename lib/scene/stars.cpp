#include <algorithm>
#include <cmath>

#include "scene/groups.hpp"

namespace toliman::scene {

namespace {

constexpr Range kWavelength = within(1, 1e6, "nm");
constexpr double kMostSteps = 4096;
constexpr Condition kSeveral =
    without("wavelength_nm", "not allowed with wavelength_nm, which gives a single wavelength");

void read_wavelength(const Reader &reader, const Row &row, Band &band) {
    band.min_nm = band.max_nm = reader.number(row);
}

void read_step(const Reader &reader, const Row &row, Band &band) {
    const double step_nm = reader.number(row), width_nm = band.max_nm - band.min_nm;
    if (width_nm <= 0)
        reader.refuse(Status::scene, "max_nm", " = %g: must be above min_nm = %g nm", band.max_nm, band.min_nm);
    const double steps = std::round(width_nm / step_nm);
    if (steps < 1 || std::fabs(steps * step_nm - width_nm) > 1e-6 * step_nm)
        reader.refuse(Status::scene, row.key, " = %g: must divide the band of %g nm into equal steps", step_nm,
                      width_nm);
    if (steps > kMostSteps)
        reader.refuse(Status::scene, row.key, " = %g: gives %.0f steps: must be at most %.0f", step_nm, steps,
                      kMostSteps);
    band.steps = static_cast<size_t>(steps);
}

constexpr Row kBandRows[] = {
    required<&Band::min_nm>("min_nm", kWavelength, "First wavelength; half weight (trapezium)").when(kSeveral),
    required<&Band::max_nm>("max_nm", kWavelength, "Last wavelength; half weight (trapezium); above min_nm")
        .when(kSeveral),
    required<read_step>("step_nm", above(0, 1e6, "nm"), "Step; divides the band into equal steps, at most 4096")
        .when(kSeveral),
    optional<read_wavelength>("wavelength_nm", kWavelength, "The only wavelength"),
};

constexpr Range kTemperature = within(100, 1e6, "K");
constexpr Condition kIsTable = is("kind", "table");
constexpr Condition kByTemperature =
    with("star_temperature_k table_temperature_k", "needs star_temperature_k and table_temperature_k");

void check_modes(const Reader &reader, const Spectrum & /*spectrum*/) {
    const std::optional<Band> &band = reader.scene().band;
    if (band && band->steps == 0)
        reader.refuse(Status::scene, "modes", ": needs a band of several wavelengths");
}

void check_weights(const Reader &reader, const Spectrum &spectrum) {
    if (spectrum.weight.size() != spectrum.wavelength_nm.size())
        reader.refuse(Status::scene, "weight", ": has %zu numbers: must have %zu, one per spectral line",
                      spectrum.weight.size(), spectrum.wavelength_nm.size());
    if (std::none_of(spectrum.weight.begin(), spectrum.weight.end(), [](double weight) { return weight > 0; }))
        reader.refuse(Status::scene, "weight", ": all are 0: at least one must be above 0");
}

constexpr Row kSpectrumRows[] = {
    required<&Spectrum::kind>("kind", Words{"blackbody table lines"},
                              "blackbody; table: interpolated linearly; lines: exactly the given wavelengths"),
    required<&Spectrum::temperature_k>("temperature_k", kTemperature, "Temperature").when(is("kind", "blackbody")),
    required<&Spectrum::file>(
        "file", "Text of two columns, wavelength_nm,relative_photon_flux, which must cover the band; a header may name "
                "angstrom, um or m, and the energies flam or fnu")
        .when(kIsTable),
    required<&Spectrum::table_temperature_k>("table_temperature_k", kTemperature, "Temperature of the table's star")
        .when(kIsTable, kByTemperature),
    required<&Spectrum::star_temperature_k>(
        "star_temperature_k", kTemperature,
        "Temperature of the star: the table is multiplied by the ratio of the black "
        "bodies of star_temperature_k and table_temperature_k")
        .when(kIsTable, kByTemperature),
    optional<&Spectrum::modes>("modes", within(-10, 10),
                               "Coefficients c_1, c_2, ... that multiply the spectrum by 1 + sum of c_k P_k(x), which "
                               "must be at least 1e-6: Legendre polynomials of x = -1 at min_nm to 1 at max_nm of the "
                               "band; the flux over the band does not change")
        .entries(1, 11)
        .when(is("kind", "blackbody table"))
        .checked<check_modes>(),
    required<&Spectrum::wavelength_nm>("wavelength_nm", kWavelength, "Wavelengths")
        .entries(1, 1024)
        .when(is("kind", "lines")),
    required<&Spectrum::weight>("weight", within(0, 1e30), "Relative photons, one value per wavelength")
        .entries(1, 1024)
        .when(is("kind", "lines"))
        .checked<check_weights>(),
};
constexpr Group kSpectrum = group_of("spectrum", "Spectrum", kSpectrumRows);

constexpr Range kFlux = above(0, 1e15, "photons/s");

void read_zero_point(const Reader &reader, const Row &row, Star &star) {
    star.photons_per_s = reader.number(row) * std::pow(10, -0.4 * *star.magnitude);
    if (!(*star.photons_per_s > kFlux.low && *star.photons_per_s <= kFlux.high))
        reader.refuse(Status::scene, "magnitude", " = %g: gives %g photons/s: must be in (%g, %g] photons/s",
                      *star.magnitude, *star.photons_per_s, kFlux.low, kFlux.high);
}

void read_detected(const Reader &reader, const Row &row, Star &star) {
    star.photons_per_s = reader.number(row);
    star.detected = true;
}

constexpr const char *kBandV = "V";

void read_magnitude_band(const Reader &reader, const Row &row, Star &star) {
    star.magnitude_band = reader.text(row.key) == kBandV ? kBandV : reader.file(row.key);
}

void check_system(const Reader &reader, const Star &star) {
    if (!star.magnitude_band.empty() && star.magnitude_band != kBandV && star.system != Star::System::ab)
        reader.refuse(Status::scene, "magnitude_system",
                      ": must be \"ab\" with the band of a file, whose flux of magnitude 0 is not known otherwise");
}

constexpr Condition kNoMagnitude = without("magnitude", "not allowed with magnitude, which gives the flux");

constexpr Row kStarRows[] = {
    required<&Star::spectrum>("spectrum", &kSpectrum),
    optional<&Star::relative_flux>("relative_flux", above(0, 1e12),
                                   "Photons over the band, relative to the other star; 1 if not given")
        .either("photons_per_s")
        .when(kNoMagnitude, without("detected_per_s", "not allowed with detected_per_s, which gives the flux")),
    optional<&Star::photons_per_s>("photons_per_s", kFlux,
                                   "Photons over the band that reach the focal plane, over an infinite image: behind "
                                   "telescope.throughput, before detector.qe; instead of relative_flux")
        .either("detected_per_s")
        .when(kNoMagnitude),
    optional<read_detected>(
        "detected_per_s", above(0, 1e15, "electrons/s"),
        "Electrons instead of photons_per_s: the same behind the quantum efficiency; detector.qe is "
        "not allowed")
        .when(kNoMagnitude),
    optional<&Star::magnitude>("magnitude", within(-50, 50, "mag"),
                               "Magnitude, instead of photons_per_s; with magnitude_band or zero_point_photons_per_s"),
    required<read_zero_point>("zero_point_photons_per_s", above(0, 1e30, "photons/s"),
                              "photons_per_s of a star of magnitude 0 with the same spectrum; photons_per_s is this "
                              "times 10^(-0.4 magnitude)")
        .either("magnitude_band")
        .when(with("magnitude", "needs magnitude")),
    optional<read_magnitude_band>(
        "magnitude_band", "Band of the magnitude, which the spectrum must cover: V (Bessell 1990), or a file "
                          "with the response to photons by wavelength; photons_per_s is the star's light through "
                          "the open pupil times telescope.throughput")
        .as(Type::text)
        .when(with("magnitude", "needs magnitude")),
    optional<&Star::system>("magnitude_system", Words{"vega ab"},
                            "Flux of magnitude 0; vega: 3.631e-11 W/m2/nm at all wavelengths, for V only; ab: 3631 Jy")
        .when(with("magnitude_band", "needs magnitude_band")),
    optional<&Star::mass_sun>("mass_sun", above(0, 1e3, "solar masses"), "Mass; for a planet"),
};
constexpr Group kStar = group_of("star", "A star", kStarRows);

void read_star(const Reader &reader, const Row &row, std::vector<Star> &stars) {
    const Reader star = reader.object(row.key);
    read_group(kStar, star, &stars.emplace_back());
    check_system(star, stars.back());
}

constexpr Row kStarsRows[] = {
    required<read_star>("A", &kStar),
    optional<read_star>("B", &kStar),
};

} // namespace

constexpr Group kBand =
    group_of("band", "Wavelengths of continuous spectra; not allowed if all spectra are lines", kBandRows);
constexpr Group kStars = group_of("stars", "Stars", kStarsRows);

} // namespace toliman::scene
