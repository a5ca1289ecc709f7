#include "linear/template.hpp"

using namespace toliman;

// Given     images, each [rows][cols]; nuisances [count][rows][cols]
// Returned  values [frames], sigma_px; goodness [frames][4], unless NULL: chi-square, its sigma, largest residual, bad
//           pixels; the status code of an error, else 0
extern "C" int shim_template(size_t rows, size_t cols, const double *reference, const double *variance,
                             const double *derivative, size_t count, const double *nuisances, size_t frames,
                             const double *counts, double *values, double *sigma_px, double *goodness) {
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
        const linear::TemplateEstimator estimator(model);
        linear::TemplateWork work = estimator.work();
        for (size_t f = 0; f < frames; f++) {
            FrameGoodness found;
            values[f] = estimator.estimate({counts + f * pixels, rows, cols, cols}, work, goodness ? &found : nullptr);
            const double numbers[] = {found.chi_square, found.sigma, found.largest,
                                      static_cast<double>(found.bad_pixels)};
            for (size_t i = 0; goodness != nullptr && i < 4; i++)
                goodness[4 * f + i] = numbers[i];
        }
        *sigma_px = estimator.sigma_px();
        return 0;
    } catch (const Error &error) {
        set_last_error(error.what());
        return static_cast<int>(error.status());
    }
}
