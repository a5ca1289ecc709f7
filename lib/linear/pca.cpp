// Method: with X the N x P matrix of residual frames minus their mean (P pixels, P >> N) the principal components of X
// are those of its N x N Gram matrix X X^T = U diag(e) U^T: the principal images are X^T U / sqrt(e), and the frames'
// components along them are U sqrt(e). So no decomposition of size P is needed. Without knowledge of the signal the
// leading component finds it only above the threshold of spiked covariance models, (A/sigma)^2 / 2 > sqrt(P/N) for a
// sinusoid of amplitude A (Baik, Ben Arous and Peche 2005, Annals of Probability 33, 1643; Paul 2007, Statistica Sinica
// 17, 1617): 4.9e-6 px on the chapter scene, against a Cramer-Rao bound of 1.2e-6 px. See Residuals::threshold_px().
// Above the threshold, with p/N and the eigenvalue l = A^2/(2 crb^2) of the signal, the squared cosine between
// principal image and signal is (1 - p/N/l^2)/(1 + p/N/l) (Paul 2007), the squared correlation between series and
// signal (1 - p/N/l^2)/(1 + 1/l) (Benaych-Georges and Nadakuditi 2012).
#include <algorithm>
#include <cmath>

#include "backend/blas.hpp"
#include "linear/components.hpp"

namespace toliman::linear {

void fix_signs(Components &components) noexcept {
    for (auto first = components.series.begin(); first != components.series.end();) {
        const auto end = first + static_cast<ptrdiff_t>(components.frames);
        const auto largest =
            std::max_element(first, end, [](double a, double b) { return std::fabs(a) < std::fabs(b); });
        if (*largest < 0)
            std::transform(first, end, first, [](double value) { return -value; });
        first = end;
    }
}

Components principal_components(size_t frames, Buffer<double> gram, size_t count) {
    double total = 0;
    for (size_t i = 0; i < frames; i++)
        total += gram[i * frames + i];
    Components out;
    out.frames = frames;
    out.series.resize(count * frames);
    out.share.resize(count);
    Buffer<double> eigenvalue(count);
    blas::leading_eigenvectors(frames, gram.data(), count, eigenvalue.data(), out.series.data());
    const double rounding = static_cast<double>(frames) * 0x1p-52 * eigenvalue[0];
    for (size_t j = 0; j < count; j++) {
        const double energy = eigenvalue[j] > rounding ? eigenvalue[j] : 0;
        for (size_t i = 0; i < frames; i++)
            out.series[j * frames + i] *= std::sqrt(energy);
        out.share[j] = energy > 0 ? energy / total : 0;
    }
    fix_signs(out);
    return out;
}

} // namespace toliman::linear
