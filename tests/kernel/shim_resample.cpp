#include "bank/resample.hpp"

using namespace toliman;

// Both images are in one piece; (x, y): the displacement in the source.
extern "C" void shim_move(const double *source, size_t rows, size_t cols, double x, double y, double *result,
                          size_t result_rows, size_t result_cols) {
    bank::Resampler resampler(cols > result_cols ? cols : result_cols);
    resampler.move({source, rows, cols, cols}, x, y, {result, result_rows, result_cols, result_cols});
}
