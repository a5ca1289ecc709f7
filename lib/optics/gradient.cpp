// Method: with J = sum over pixels u of W(u) I(u) and I = sum over lambda of c |F|^2, where F = sum over cells of
// E exp(-2 pi i x u), an OPD of dz in a cell changes its field by (2 pi i/lambda) E dz. Hence
//     dJ/dz = sum over lambda of (4 pi c/lambda) Im(conj(E) G),   G(x) = sum over u of W F exp(+2 pi i x u):
// the adjoint of the transform is applied to W F, once per wavelength and star, whatever the number of cells.
// Reference: Jurling and Fienup 2014, J. Opt. Soc. Am. A 31, 1348 (reverse-mode differentiation of phase retrieval).
#include "optics/gradient.hpp"

#include <algorithm>

#include "base/constants.hpp"
#include "base/workers.hpp"
#include "optics/matrix_dft.hpp"
#include "optics/propagate.hpp"

namespace toliman::optics {

void add_opd_gradient(const Pupil &pupil, const Light &light, const Grid &grid, size_t star, const double *weights,
                      unsigned workers, double *gradient) {
    const long double offset[2] = {light.offset_px[star][0], light.offset_px[star][1]};
    const size_t count = light.wavelength_m.size(), cells = pupil.samples * pupil.samples;
    std::vector<Buffer<double>> parts(std::min(count, kWavelengthChunks));
    run_jobs(workers, parts.size(), [&](size_t part) {
        MatrixDft dft(pupil, grid, 1);
        parts[part].resize(cells);
        for (size_t i = part; i < count; i += parts.size()) {
            if (light.photons[star][i] == 0)
                continue;
            const long double wavenumber = 1 / static_cast<long double>(light.wavelength_m[i]);
            dft.transform(wavenumber, offset, {});
            dft.add_opd_gradient(wavenumber, weights, intensity_factor(pupil, grid, wavenumber, light.photons[star][i]),
                                 parts[part].data());
        }
    });
    for (const Buffer<double> &part : parts)
        for (size_t i = 0; i < cells; i++)
            gradient[i] += part[i];
}

} // namespace toliman::optics
