// C interface of the interpolation from every other sample.
#include <algorithm>

#include "optics/half_band.hpp"

using namespace toliman;

extern "C" {

size_t shim_half_band(double cutoff, double accuracy) {
    return optics::make_half_band(cutoff, accuracy).size();
}

// The sparse grid of a dense one.
void shim_sparse_size(double cutoff, double accuracy, size_t rows, size_t cols, size_t *sparse_rows,
                      size_t *sparse_cols) {
    const optics::Grid grid = optics::sparse_grid({rows, cols, 1e-6L}, optics::make_half_band(cutoff, accuracy));
    *sparse_rows = grid.rows;
    *sparse_cols = grid.cols;
}

// adjoint: from the dense grid to the sparse one.
void shim_half_band_apply(double cutoff, double accuracy, size_t rows, size_t cols, int adjoint, const double *from,
                          size_t count, double *to) {
    const optics::Grid dense = {rows, cols, 1e-6L};
    const optics::HalfBand weights = optics::make_half_band(cutoff, accuracy);
    const Buffer<double> in(from, from + count);
    const Buffer<double> out =
        adjoint != 0 ? optics::spread(in, dense, weights) : optics::interpolated(in, dense, weights);
    std::copy(out.begin(), out.end(), to);
}
}
