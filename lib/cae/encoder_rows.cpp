// Method: a stage needs three rows of box sums for a row of its output, and two rows of its input for a row of box
// sums. Each row is passed to the next stage as soon as it is complete, so that all stages advance together:
//     image row -> box sums -> coarse row = row of the next image -> box sums -> ... -> features -> latent
// Why: the images of all levels are 1.3 MB (`flight`), and with the frame and the planes of the preprocessing more than
// a core's own cache. The rows in use are 80 kB. Fetching the frame's next rows also overlaps with the products of this
// one.
#include "cae/encoder_rows.hpp"

#include <algorithm>

#include "kernels/conv.hpp"

namespace toliman::cae {

namespace {

constexpr size_t kLine = 64 / sizeof(float);                  // of the cache
alignas(64) constexpr float kZeros[kernels::kBoxFloats] = {}; // the border's first and last row

constexpr size_t row_size(const kernels::ConvShape &shape) noexcept {
    return (2 * shape.cols + 2) * shape.fine_channels;
}
// The first pixel inside the border starts a line.
constexpr size_t lead(const kernels::ConvShape &shape) noexcept {
    return (kLine - shape.fine_channels % kLine) % kLine;
}
constexpr size_t row_stride(const kernels::ConvShape &shape) noexcept {
    return (lead(shape) + row_size(shape) + kLine - 1) / kLine * kLine;
}

} // namespace

EncoderRows::EncoderRows(const Layout &layout)
    : layout_(&layout), band_stride_(row_stride(layout.shapes[0])), levels_() {
    size_t size = (kBand + 1) * band_stride_;
    for (const kernels::ConvShape &shape : layout.shapes)
        size += 2 * row_stride(shape) + 3 * kernels::kBoxFloats;
    memory_.resize(size);
    float *at = memory_.data();
    for (size_t s = 0; s < kStages; s++) {
        for (float *&row : levels_[s].fine) {
            row = at + lead(layout.shapes[s]);
            at += s == 0 ? (kBand + 1) * band_stride_ / 2 : row_stride(layout.shapes[s]);
        }
        for (float *&boxes : levels_[s].boxes) {
            boxes = at;
            at += kernels::kBoxFloats;
        }
    }
}

void EncoderRows::start(const Parameters &parameters, const Packed &encoder) noexcept {
    parameters_ = &parameters;
    encoder_ = &encoder;
    latent_ = static_cast<double>(parameters[kLatentBias][0]);
    for (Level &level : levels_)
        level.rows = 1;
    before_band_ = 0;
}

void EncoderRows::push_band() noexcept {
    float *const before = levels_[0].fine[0];
    for (size_t i = 0; i < kBand; i++)
        advance(0);
    std::copy_n(before + kBand * band_stride_, row_size(layout_->shapes[0]), before);
    before_band_ += kBand;
}

const float *EncoderRows::fine(size_t stage, size_t row) const noexcept {
    if (row == 0 || row == 2 * layout_->shapes[stage].rows + 1)
        return kZeros;
    return stage == 0 ? levels_[0].fine[0] + (row - before_band_) * band_stride_ : levels_[stage].fine[row % 2];
}

float *EncoderRows::next(size_t stage) noexcept {
    return levels_[stage].fine[levels_[stage].rows % 2] + kChannels[stage];
}

void EncoderRows::sum_boxes(size_t stage) noexcept {
    Level &level = levels_[stage];
    const size_t row = level.rows++;
    kernels::conv_kernels().box_row(layout_->shapes[stage], fine(stage, row - 1), fine(stage, row),
                                    level.boxes[(row - 1) % 3]);
}

// A row of the stage's output needs box sums 2 y, 2 y + 1 and 2 y + 2, hence the bordered rows to 2 y + 3.
void EncoderRows::advance(size_t stage) noexcept {
    const kernels::ConvShape &shape = layout_->shapes[stage];
    Level &level = levels_[stage];
    sum_boxes(stage);
    if (level.rows == 2 * shape.rows + 1)
        sum_boxes(stage); // with the border's last row
    if (level.rows % 2 != 0 || level.rows < 4)
        return;
    const size_t y = level.rows / 2 - 2;
    const float *const boxes[3] = {level.boxes[2 * y % 3], level.boxes[(2 * y + 1) % 3], level.boxes[(2 * y + 2) % 3]};
    float features[(kLargestSide >> kStages) * kDeepChannels];
    const bool last = stage + 1 == kStages;
    kernels::conv_kernels().down_row(shape, boxes, (*encoder_)[stage].data(), (*parameters_)[conv_bias(stage)],
                                     last ? features : next(stage + 1));
    if (last)
        latent_ += latent_of_row(*parameters_, y, features);
    else
        advance(stage + 1);
}

} // namespace toliman::cae
