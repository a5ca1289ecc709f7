// C interface of the dates of a bank and of displaced images.
#include "bank/grid.hpp"
#include "bank/resample.hpp"

using namespace toliman::bank;

extern "C" {

// Given     path: writes the difference {x, y} at a time
// Returned  dates[number][3]: date, first, last, of at most `capacity`; their number
size_t shim_dates(double first, double last, double spacing_px, void (*path)(double, double *), size_t capacity,
                  double *dates) {
    const auto found = dates_of(first, last, spacing_px, [path](double days) {
        std::array<double, 2> difference = {};
        path(days, difference.data());
        return difference;
    });
    for (size_t i = 0; i < found.size() && i < capacity; i++) {
        dates[3 * i] = found[i].days;
        dates[3 * i + 1] = found[i].first;
        dates[3 * i + 2] = found[i].last;
    }
    return found.size();
}

double shim_place(size_t i, size_t places) {
    return shift_of(i, places);
}
}

using namespace toliman;

// Both images are in one piece; (x, y): the displacement in the source.
extern "C" void shim_move(const double *source, size_t rows, size_t cols, double x, double y, double *result,
                          size_t result_rows, size_t result_cols) {
    bank::Resampler resampler(cols > result_cols ? cols : result_cols);
    resampler.move({source, rows, cols, cols}, x, y, {result, result_rows, result_cols, result_cols});
}
