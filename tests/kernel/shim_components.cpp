#include <algorithm>

#include "kernels/poisson.hpp"
#include "kernels/random.hpp"
#include "linear/components.hpp"
#include "linear/residuals.hpp"

using namespace toliman;

namespace {
int give(const linear::Components &found, double *series, double *share) {
    std::copy(found.series.begin(), found.series.end(), series);
    std::copy(found.share.begin(), found.share.end(), share);
    return 0;
}
} // namespace

// Given     images, each [rows][cols]; nuisances [count][rows][cols]; counts [frames][rows][cols]
// Returned  gram [frames][frames], bounds {crb_px, threshold_px}; the status code of an error, else 0
extern "C" int shim_gram(size_t rows, size_t cols, const double *reference, const double *variance,
                         const double *derivative, size_t count, const double *nuisances, int raw, size_t bin,
                         size_t frames, const double *counts, unsigned workers, double *gram, double *bounds) {
    const size_t pixels = rows * cols;
    FrameModel model;
    model.rows = rows;
    model.cols = cols;
    model.reference.assign(reference, reference + pixels);
    model.variance.assign(variance, variance + pixels);
    model.derivative.assign(derivative, derivative + pixels);
    for (size_t k = 0; k < count; k++)
        model.projected.push_back({"", Buffer<double>(nuisances + k * pixels, nuisances + (k + 1) * pixels)});
    try {
        linear::Residuals residuals(model, {raw != 0, bin, frames});
        for (size_t f = 0; f < frames; f++)
            residuals.push({counts + f * pixels, rows, cols, cols});
        const Buffer<double> products = residuals.gram(workers, nullptr);
        std::copy(products.begin(), products.end(), gram);
        bounds[0] = residuals.crb_px();
        bounds[1] = residuals.threshold_px();
        return 0;
    } catch (const Error &error) {
        set_last_error(error.what());
        return static_cast<int>(error.status());
    }
}

// Returned  series [count][frames], share [count]
extern "C" int shim_pca(size_t frames, const double *gram, size_t count, double *series, double *share) {
    return give(linear::principal_components(frames, Buffer<double>(gram, gram + frames * frames), count), series,
                share);
}

// Returned  series [count][frames], share [count], objective, iterations
extern "C" int shim_dictionary(size_t frames, const double *gram, size_t pixels, size_t count, double lambda,
                               size_t iterations, uint64_t seed, double *series, double *share, double *objective,
                               size_t *done) {
    linear::DictionaryOptions options;
    options.count = count;
    options.lambda = lambda;
    options.iterations = iterations;
    options.seed = seed;
    const auto found = linear::sparse_dictionary(frames, Buffer<double>(gram, gram + frames * frames), pixels, options);
    *objective = found.objective;
    *done = found.converged ? found.iterations : 0;
    return give(found, series, share);
}

// Returned  out [count], the normal variates from which atoms are initialised
extern "C" void shim_atom_normals(uint64_t seed, size_t count, double *out) {
    kernels::Rng rng(seed, kernels::kStreamAtoms);
    std::generate_n(out, count, [&] { return rng.normal(); });
}
