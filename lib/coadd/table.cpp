// Method: a place is a whole number of pixels and a phase, one of steps x steps. An image of each phase extends
// `range` pixels beyond the frame, so that another whole number of pixels is another first pixel of the same image: the
// table has steps^2 images instead of one for each of the (2 range steps + 1)^2 places. A model draws images of the
// frame's size only, so that each corner of a larger one is drawn with the stars moved by `range` px away from it.
// Integers of 16 bits: the frames have no more, and the table is read once per frame, from a cache as far as possible.
// Rounding is 2^-17 of the brightest pixel. For stars of 4.8e5 electrons and peaks of 10^3 that is 1e-3 of the noise
// of a pixel, and moves places by 1e-6 px.
// 8 steps per pixel: from at most 1/16 px, one linear step ends within 1e-4 px (square of 2 pi/16 times 0.43 cycles).
#include "coadd/table.hpp"

#include <algorithm>

#include "base/workers.hpp"

namespace toliman::coadd {

namespace {

constexpr size_t kImages = 3;
using Index = fit::Index;

size_t padded(size_t cols) noexcept {
    return (cols + kernels::kCoaddLanes - 1) / kernels::kCoaddLanes * kernels::kCoaddLanes;
}

} // namespace

Table::Table(const fit::Fit &fit, const fit::Prediction &prediction, int range, int steps, unsigned workers,
             const Progress &progress)
    : range_(range), steps_(steps), rows_(fit.rows() + 2 * static_cast<size_t>(range)),
      cols_(fit.cols() + 2 * static_cast<size_t>(range)), stride_(padded(cols_)),
      light_scale_(static_cast<size_t>(steps * steps)), slope_scale_(light_scale_.size()) {
    const fit::Fit::Start start = fit.start_of(prediction);
    const size_t phases = light_scale_.size(), per_pixel = static_cast<size_t>(steps);
    values_.resize(checked_product(checked_product(phases * kImages, rows_, "frames"), stride_, "frames") +
                   kernels::kCoaddLanes); // the last row is read beyond its end
    std::fill_n(values_.end() - kernels::kCoaddLanes, kernels::kCoaddLanes, uint16_t{0});
    const size_t count = std::min<size_t>(workers, phases);
    std::vector<fit::Work> works;
    std::vector<Buffer<double>> scratch;
    for (size_t w = 0; w < count; w++) {
        works.push_back(fit.model().work());
        scratch.emplace_back(kImages * rows_ * stride_);
    }
    const auto draw_phases = [&](size_t worker) {
        for (size_t phase = worker; phase < phases; phase += count) {
            double values[fit::kMostParameters];
            std::copy(std::begin(start.values), std::end(start.values), values);
            for (size_t i = Index::x_a; i <= Index::y_b; i++)
                values[i] += place(static_cast<int>(i % 2 == 0 ? phase % per_pixel : phase / per_pixel));
            draw(fit, values, phase, works[worker], scratch[worker]);
            if (worker == 0)
                progress.report("images of the places", static_cast<double>(phase + 1) / static_cast<double>(phases));
        }
    };
    run_jobs(static_cast<unsigned>(count), count, draw_phases);
}

void Table::draw(const fit::Fit &fit, const double *values, size_t phase, fit::Work &work, Buffer<double> &scratch) {
    const size_t size = rows_ * stride_;
    std::fill(scratch.begin(), scratch.end(), 0.0);
    for (const int side_y : {-1, 1})
        for (const int side_x : {-1, 1}) {
            double moved[fit::kMostParameters];
            std::copy_n(values, fit::kMostParameters, moved);
            for (size_t i = Index::x_a; i <= Index::y_b; i++)
                moved[i] -= range_ * (i % 2 == 0 ? side_x : side_y);
            const size_t row = side_y > 0 ? rows_ - fit.rows() : 0, col = side_x > 0 ? cols_ - fit.cols() : 0;
            fit.model().visit(nullptr, moved, 0, work, [&](const fit::Model::Row &drawn) {
                double *const out = &scratch[(row + drawn.row) * stride_ + col];
                for (size_t c = 0; c < fit.cols(); c++) {
                    out[c] = drawn.light[c];
                    out[size + c] = drawn.derivatives[Index::x_a][c] + drawn.derivatives[Index::x_b][c];
                    out[2 * size + c] = drawn.derivatives[Index::y_a][c] + drawn.derivatives[Index::y_b][c];
                }
            });
        }
    for (size_t which = 0; which < kImages; which++)
        fit.model().readout().couple(rows_, stride_, &scratch[which * size]);
    double peak = 0, slope = 0;
    for (size_t i = 0; i < size; i++) {
        peak = std::fmax(peak, scratch[i]);
        slope = std::fmax(slope, std::fmax(std::fabs(scratch[size + i]), std::fabs(scratch[2 * size + i])));
    }
    light_scale_[phase] = static_cast<float>(peak / UINT16_MAX);
    slope_scale_[phase] = static_cast<float>(slope / INT16_MAX);
    const double light_unit = UINT16_MAX / peak, slope_unit = INT16_MAX / slope;
    for (size_t i = 0; i < size; i++) {
        image(phase, 0)[i] = static_cast<uint16_t>(std::lround(std::fmax(0, scratch[i] * light_unit)));
        for (const size_t which : {size_t{1}, size_t{2}})
            image(phase, which)[i] =
                static_cast<uint16_t>(static_cast<int16_t>(std::lround(scratch[which * size + i] * slope_unit)));
    }
}

double Table::most_photons() const noexcept {
    return double{*std::max_element(light_scale_.begin(), light_scale_.end())} * UINT16_MAX;
}

kernels::CoaddModel Table::model(const Cell &cell) const noexcept {
    const auto whole = [this](int steps) { return (steps < 0 ? steps - steps_ + 1 : steps) / steps_; };
    const int x = whole(cell.x), y = whole(cell.y);
    const auto phase = static_cast<size_t>((cell.y - y * steps_) * steps_ + (cell.x - x * steps_));
    const size_t first = static_cast<size_t>(range_ - y) * stride_ + static_cast<size_t>(range_ - x);
    const uint16_t *const light = &values_[phase * kImages * rows_ * stride_];
    const auto *const slopes = reinterpret_cast<const int16_t *>(light) + first;
    return {light + first, slopes + rows_ * stride_, slopes + 2 * rows_ * stride_,
            stride_,       light_scale_[phase],      slope_scale_[phase]};
}

} // namespace toliman::coadd
