/* Noisy frames against their expected mean and variance, pixel by pixel. */
#ifndef TOLIMAN_TESTS_FRAME_STATISTICS_H
#define TOLIMAN_TESTS_FRAME_STATISTICS_H

#include "scene_text.h"

/* 100 frames without displacement: both chi-square sums over the pixels must be within 5 sigma. kurtosis is that of a
 * pixel's counts; Poisson counts of mean m have 1/m. */
static inline void check_frames(const toliman_sim *sim, const double *mean, const double *variance, double kurtosis,
                                int whole_counts) {
    enum { count = 100 };
    const toliman_sim_info info = sim_info_of(sim);
    const size_t pixels = (size_t)(info.rows * info.cols);
    double *const frames = malloc(count * pixels * sizeof *frames), still[count] = {0};
    assert_non_null(frames);
    assert_ok(toliman_sim_frame(sim, still, 11, 0, count, frames));
    double means = 0, variances = 0, total = 0;
    for (size_t i = 0; i < pixels; i++) {
        double sum = 0, squares = 0;
        for (size_t k = 0; k < count; k++) {
            const double value = frames[k * pixels + i], off = value - mean[i];
            if (whole_counts)
                assert_true(value >= 0 && value == floor(value));
            sum += off;
            squares += off * off;
        }
        means += sum * sum / (count * variance[i]);
        variances += (squares - sum * sum / count) / ((count - 1) * variance[i]);
        total += sum / sqrt(count * variance[i]);
    }
    const double n = (double)pixels;
    assert_close(means / n, 1, 0, 5 * sqrt(2 / n));
    assert_close(variances / n, 1, 0, 5 * sqrt((2 + kurtosis) / n / count));
    assert_close(total / n, 0, 0, 5 / sqrt(n));
    free(frames);
}

#endif
