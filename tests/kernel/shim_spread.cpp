// C interface of the direct sums, of the spreading kernel and of the non-uniform FFT that uses it.
#include <vector>

#include "isa_tables.hpp"
#include "kernels/direct.hpp"
#include "kernels/spread.hpp"
#include "period/batch/nufft.hpp"

using namespace toliman;

extern "C" void shim_spread(int isa, const double *t_high, const double *t_low, const double *w, const double *x,
                            size_t n, size_t width, size_t lanes, const double *coefficients, double df, double f_high,
                            double f_low, double cells, size_t pairs, double *const *grids) {
    KERNELS(spread, isa)
        .spread({t_high, t_low, {w, x}, n}, {width, lanes, 3, coefficients}, {df, f_high, f_low, cells}, pairs, grids);
}

// Sums of w and x at frequencies (k - modes/2) df + f; returns the error bound for the requested error.
extern "C" double shim_nufft(size_t modes, double error, const double *t_high, const double *t_low, const double *w,
                             const double *x, size_t n, double df, double f_high, double f_low, double *sums_w,
                             double *sums_x, size_t *cells) {
    const period::Nufft::Choice choice = period::Nufft::choose(modes, error);
    const period::Nufft nufft(choice);
    std::vector<Buffer<double>> grids(4, Buffer<double>(nufft.grid_size()));
    double *at[] = {grids[0].data(), grids[1].data(), grids[2].data(), grids[3].data()};
    nufft.spread({t_high, t_low, {w, x}, n}, df, f_high, f_low, 2, at);
    for (double *grid : at)
        nufft.transform(grid);
    for (size_t k = 0; k < modes; k++)
        for (size_t pair = 0; pair < 2; pair++) {
            const std::complex<double> sum = nufft.sum(at[2 * pair], at[2 * pair + 1], k);
            double *out = pair == 0 ? sums_w : sums_x;
            out[2 * k] = sum.real();
            out[2 * k + 1] = sum.imag();
        }
    *cells = choice.cells;
    return nufft.error();
}

extern "C" void shim_direct(int isa, const double *half_high, const double *half_low, const double *t_high,
                            const double *t_low, const double *w, const double *x, size_t n, double *high,
                            double *low) {
    KERNELS(direct, isa).direct(half_high, half_low, {t_high, t_low, w, x, n}, high, low);
}
