// Method: synthetic photometry with photons. A star of magnitude m has the spectrum n(lambda), relative photons per
// wavelength, times the k for which its photons in the band are those of magnitude 0 times 10^(-0.4 m):
//     k integral n S dlambda = 10^(-0.4 m) integral n_0 S dlambda,
// with the response S to photons. n_0 is f lambda/(h c) with the flux f of magnitude 0, the same at all wavelengths
// (vega), or F/(h lambda) with F = 3631 Jy (ab). The photons at the focal plane are k times the open area times the
// trapezium sum of n and the throughput over the wavelengths of the scene.
// V: the table is that of Bessell (1990, PASP 102, 1181), which is the response to energy: lambda S, not S (Bessell
// and Murphy 2012, PASP 124, 140). f is that of Bessell, Castelli and Plez (1998, A&A 333, 231, table A2) for the
// same table: 363.1e-11 erg/s/cm2/A. Read as S, the table would make a G2V star brighter by 0.2 %.
// The integrals are Simpson's rule between the wavelengths of both tables, in steps of at most 1 nm: exact for products
// of the linear pieces.
#include "optics/photometry.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "optics/efficiency.hpp"
#include "optics/spectrum.hpp"

namespace toliman::optics {

namespace {

constexpr double kPlanck = 6.62607015e-34, kLight = 299792458; // J s, m/s
constexpr double kVega = 3.631e-2;                             // W/m2 per m of wavelength
constexpr double kAb = 3.631e-23;                              // W/m2/Hz
constexpr double kMostStep = 1, kMostParts = 1000;             // nm; of an interval
constexpr double kMostFlux = 1e15;                             // photons/s, as of photons_per_s

constexpr double kFirstV = 470, kStepV = 10; // nm
constexpr double kV[] = {0,     0.030, 0.163, 0.458, 0.780, 0.967, 1.000, 0.973, 0.898, 0.792, 0.684, 0.574,
                         0.461, 0.359, 0.270, 0.197, 0.135, 0.081, 0.045, 0.025, 0.017, 0.013, 0.009, 0};

// The response of a band to photons.
class Response {
  public:
    explicit Response(const std::string &band) {
        if (band != "V") {
            table_.emplace(band, Curve::response);
            knots_ = table_->wavelength_nm();
            trim();
            return;
        }
        for (size_t i = 0; i < std::size(kV); i++)
            knots_.push_back(kFirstV + kStepV * static_cast<double>(i));
    }
    const std::vector<double> &knots() const noexcept { return knots_; }
    double at(double nm) const noexcept {
        if (table_)
            return table_->at(nm);
        const double place = std::clamp((nm - kFirstV) / kStepV, 0.0, static_cast<double>(std::size(kV) - 1));
        const size_t i = std::min(static_cast<size_t>(place), std::size(kV) - 2);
        const double share = place - static_cast<double>(i);
        return (kV[i] + share * (kV[i + 1] - kV[i])) / nm;
    }

  private:
    // Removes knots beyond which there is no response.
    void trim() {
        const auto responds = [this](double nm) { return table_->at(nm) > 0; };
        auto first = std::find_if(knots_.begin(), knots_.end(), responds),
             last = std::find_if(knots_.rbegin(), knots_.rend(), responds).base(); // behind the last
        first -= first != knots_.begin() && first != knots_.end() ? 1 : 0;
        last += last != knots_.end() ? 1 : 0;
        if (first < last)
            knots_ = std::vector<double>(first, last);
    }

    std::optional<SpectrumTable> table_;
    std::vector<double> knots_;
};

// Simpson's rule between neighbouring knots, in steps of at most kMostStep.
template <class Function> double integral(const std::vector<double> &knots, Function function) {
    double sum = 0;
    for (size_t i = 0; i + 1 < knots.size(); i++) {
        const double width = knots[i + 1] - knots[i], parts = std::min(std::ceil(width / kMostStep), kMostParts),
                     step = width / parts;
        for (double part = 0; part < parts; part++) {
            const double a = knots[i] + part * step;
            sum += step / 6 * (function(a) + 4 * function(a + step / 2) + function(a + step));
        }
    }
    return sum;
}

// Photons of magnitude 0 per s, m2 and nm.
double photons_of_zero(Star::System system, double nm) noexcept {
    const double m = nm * 1e-9;
    return 1e-9 * (system == Star::System::vega ? kVega * m / (kPlanck * kLight) : kAb / (kPlanck * m));
}

// Photons per s, m2 and nm at the telescope, of the star's spectrum of 1.
double scale_of(const Scene &scene, const Star &star, char name, const Continuum &spectrum) {
    const Response response(star.magnitude_band);
    std::vector<double> knots = response.knots();
    const double first = knots.front(), last = knots.back();
    if (spectrum.table()) {
        const SpectrumTable &table = *spectrum.table();
        if (!table.covers(first, last))
            fail(Status::scene,
                 "%s: {stars.%c.magnitude_band}: %g to %g nm: must be within the range of %s, %g to %g nm",
                 scene.source.c_str(), name, first, last, star.spectrum.file.c_str(), table.first_nm(),
                 table.last_nm());
        for (const double nm : table.wavelength_nm())
            if (nm > first && nm < last)
                knots.push_back(nm);
        std::sort(knots.begin(), knots.end());
    }
    const double zero = integral(knots, [&](double nm) { return response.at(nm) * photons_of_zero(star.system, nm); }),
                 own = integral(knots, [&](double nm) { return response.at(nm) * spectrum.at(nm); });
    if (!(zero > 0) || !(own > 0))
        fail(Status::scene, "%s: {stars.%c.magnitude_band}: the star has no light in it", scene.source.c_str(), name);
    return std::pow(10, -0.4 * *star.magnitude) * zero / own;
}

double photons_per_s(const Scene &scene, size_t star, double area_m2, const Efficiency &efficiency) {
    const Star &known = scene.stars[star];
    const char name = star == 0 ? 'A' : 'B';
    if (known.spectrum.kind == Spectrum::Kind::lines || scene.band->steps == 0)
        fail(Status::scene,
             "%s: {stars.%c.magnitude_band}: needs a continuous spectrum over a band of several wavelengths",
             scene.source.c_str(), name);
    const Continuum spectrum(known.spectrum);
    const double scale = scale_of(scene, known, name, spectrum),
                 step = (scene.band->max_nm - scene.band->min_nm) / static_cast<double>(scene.band->steps);
    double sum = 0;
    for (const Sample &sample : sample_band(*scene.band))
        sum += sample.weight * spectrum.at(sample.wavelength_nm) * efficiency.throughput(sample.wavelength_nm);
    const double flux = scale * area_m2 * step * sum;
    if (!(flux > 0 && flux <= kMostFlux))
        fail(Status::scene, "%s: {stars.%c.magnitude} = %g: gives %g photons/s: must be in (0, %g] photons/s",
             scene.source.c_str(), name, *known.magnitude, flux, kMostFlux);
    return flux;
}

} // namespace

void set_fluxes(Scene &scene, double area_m2) {
    std::optional<Efficiency> efficiency;
    for (size_t star = 0; star < scene.stars.size(); star++) {
        Star &known = scene.stars[star];
        if (known.magnitude_band.empty() || known.photons_per_s)
            continue;
        if (!efficiency)
            efficiency.emplace(scene);
        known.photons_per_s = photons_per_s(scene, star, area_m2, *efficiency);
    }
}

} // namespace toliman::optics
