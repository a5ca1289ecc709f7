// Method: images are sampled finely enough that the light of a pixel is at most a few times that of its brightest
// neighbour. A pixel is a spike if its electrons exceed kRatio times those, plus kSigmas of the noise. It needs no
// places of the stars, so that it finds what keeps the steps of a fit from ending; the fit itself leaves out the pixels
// that its model does not explain.
#include "fit/spikes.hpp"

#include <algorithm>
#include <cmath>

#include "frame/bad_pixels.hpp"

namespace toliman::fit {

namespace {

constexpr double kRatio = 4, kSigmas = 10;

// Of the pixels around (row, col), inside the frame.
struct Around {
    double most = 0, mean = 0; // counts
};

Around around(const ImageView<const double> &counts, size_t row, size_t col) noexcept {
    Around found = {-INFINITY, 0};
    double sum = 0;
    size_t number = 0;
    for (size_t r = row > 0 ? row - 1 : 0; r < std::min(row + 2, counts.rows); r++)
        for (size_t c = col > 0 ? col - 1 : 0; c < std::min(col + 2, counts.cols); c++)
            if (r != row || c != col) {
                found.most = std::max(found.most, counts.row(r)[c]);
                sum += counts.row(r)[c];
                number++;
            }
    found.mean = sum / static_cast<double>(number);
    return found;
}

} // namespace

bool remove_spikes(const ImageView<const double> &counts, const kernels::CountModel &how, Buffer<double> &out) {
    size_t spikes = 0;
    const auto electrons = [&how](double count) { return std::max(0.0, (count - how.bias) * how.e_per_count); };
    for (size_t r = 0; r < counts.rows; r++)
        for (size_t c = 0; c < counts.cols; c++) {
            const Around near = around(counts, r, c);
            const double light = electrons(near.most);
            if (!(electrons(counts.row(r)[c]) > kRatio * light + kSigmas * std::sqrt(light + how.added_variance + 1)))
                continue;
            if (++spikes > kMostBadPixels)
                return false;
            if (spikes == 1) {
                out.resize(counts.rows * counts.cols);
                for (size_t row = 0; row < counts.rows; row++)
                    std::copy_n(counts.row(row), counts.cols, &out[row * counts.cols]);
            }
            out[r * counts.cols + c] = near.mean;
        }
    return spikes > 0;
}

} // namespace toliman::fit
