// Method: with J = sum over pixels u of W(u) I(u) and I = sum over lambda of c |F|^2, where F = sum over cells of
// E exp(-2 pi i x u), an OPD of dz in a cell changes its field by (2 pi i/lambda) E dz. Hence
//     dJ/dz = sum over lambda of (4 pi c/lambda) Im(conj(E) G),   G(x) = sum over u of W F exp(+2 pi i x u):
// the adjoint of the transform is applied to W F, once per wavelength and star, whatever the number of cells.
// Images with the same F at each wavelength and other c, of stars at the same place, take one adjoint together: that of
// (sum over images of c W) F.
// Reference: Jurling and Fienup 2014, J. Opt. Soc. Am. A 31, 1348 (reverse-mode differentiation of phase retrieval).
#include "optics/gradient.hpp"

#include <algorithm>

#include "base/constants.hpp"
#include "base/work_pool.hpp"
#include "base/workers.hpp"
#include "optics/matrix_dft.hpp"
#include "optics/propagate.hpp"

namespace toliman::optics {

namespace {

// Weights of |F|^2 at a wavelength, up to a factor.
struct Weighting {
    const double *weights;
    double factor;
};

// sum over images of c W; one image alone is not copied. `sum` holds the others.
Weighting combine(const std::vector<double> &factors, const std::vector<const double *> &weights,
                  Buffer<double> &sum) noexcept {
    if (weights.size() == 1)
        return {weights[0], factors[0]};
    for (size_t i = 0; i < sum.size(); i++) {
        double value = 0;
        for (size_t k = 0; k < weights.size(); k++)
            value += factors[k] * weights[k][i];
        sum[i] = value;
    }
    return {sum.data(), 1};
}

void add_at(const Pupil &pupil, const Light &light, const Grid &grid, const long double *offset,
            const std::vector<std::vector<double>> &spectra, const std::vector<const double *> &weights,
            unsigned workers, double *gradient) {
    const size_t count = light.wavelength_m.size(), cells = pupil.samples * pupil.samples;
    std::vector<Buffer<double>> parts(std::min(count, kWavelengthChunks));
    run_jobs(workers, parts.size(), [&](size_t part) {
        MatrixDft dft(pupil, grid, 1);
        parts[part].resize(cells);
        Buffer<double> sum(spectra.size() > 1 ? grid.rows * grid.cols : 0);
        std::vector<double> factors(spectra.size());
        for (size_t i = part; i < count; i += parts.size()) {
            const long double wavenumber = 1 / static_cast<long double>(light.wavelength_m[i]);
            for (size_t k = 0; k < spectra.size(); k++)
                factors[k] = intensity_factor(pupil, grid, wavenumber, spectra[k][i]);
            if (std::all_of(factors.begin(), factors.end(), [](double factor) { return factor == 0; }))
                continue;
            const Weighting all = combine(factors, weights, sum);
            const auto moved = light.dispersed_px(light.wavelength_m[i]);
            const long double at[2] = {offset[0] + moved[0], offset[1] + moved[1]};
            dft.transform(wavenumber, at, {});
            dft.add_opd_gradient(wavenumber, all.weights, all.factor, parts[part].data());
        }
    });
    for (const Buffer<double> &part : parts)
        for (size_t i = 0; i < cells; i++)
            gradient[i] += part[i];
}

} // namespace

void add_opd_gradient(const Pupil &pupil, const Light &light, const Grid &grid, size_t star, const double *weights,
                      unsigned workers, double *gradient) {
    const long double offset[2] = {light.offset_px[star][0], light.offset_px[star][1]};
    add_at(pupil, light, grid, offset, {light.photons[star]}, {weights}, workers, gradient);
}

void add_opd_gradient(const Pupil &pupil, const Light &light, const Grid &grid,
                      const std::vector<std::vector<double>> &spectra, const std::vector<const double *> &weights,
                      unsigned workers, double *gradient) {
    const long double offset[2] = {light.offset_px[0][0], light.offset_px[0][1]};
    add_at(pupil, light, grid, offset, spectra, weights, workers, gradient);
}

void add_coverage_gradient(const Pupil &pupil, const Light &light, const Grid &grid, size_t star,
                           const ImageWeights &weights, unsigned workers, double *gradient) {
    const size_t count = light.wavelength_m.size();
    const long double offset[2] = {light.offset_px[star][0], light.offset_px[star][1]};
    std::vector<Buffer<double>> parts(std::min(count, kWavelengthChunks));
    WorkPool<MatrixDft> transforms([&] { return MatrixDft(pupil, grid, 4); });
    run_jobs(workers, parts.size(), [&](size_t part) {
        WorkPool<MatrixDft>::Lease lease(transforms);
        MatrixDft &dft = *lease;
        parts[part].resize(pupil.mixed.size());
        for (size_t i = part; i < count; i += parts.size()) {
            const long double wavenumber = 1 / static_cast<long double>(light.wavelength_m[i]);
            const double factor = intensity_factor(pupil, grid, wavenumber, light.photons[star][i]);
            if (factor == 0)
                continue;
            const std::vector<kernels::FieldTerm> terms = {
                position_term(0, pupil, grid, wavenumber, light.axis[0], light.axis[1]),
                position_term(0, pupil, grid, wavenumber, -light.axis[1], light.axis[0]),
                focus_term(0, pupil, wavenumber)};
            const auto moved = light.dispersed_px(light.wavelength_m[i]);
            const long double at[2] = {offset[0] + moved[0], offset[1] + moved[1]};
            dft.transform(wavenumber, at, terms);
            dft.add_coverage_gradient(wavenumber, terms,
                                      {{0, 0, factor, weights.image},
                                       {0, 1, 2 * factor, weights.along},
                                       {0, 2, 2 * factor, weights.across},
                                       {0, 3, 2 * factor, weights.focus}},
                                      parts[part].data());
        }
    });
    for (const Buffer<double> &part : parts)
        for (size_t i = 0; i < part.size(); i++)
            gradient[i] += part[i];
}

} // namespace toliman::optics
