// Method: after lost or added bytes, all frames of a file are shifted by the same number of bytes. The library rejects
// such a frame as a misfit and calls find(), which searches the file for pixels like those of a good frame. Once the
// library accepts the frame found, the shift is kept for the frames that follow.
#include "downlink/realigner.hpp"

namespace cli {

namespace {

size_t bytes_of(const toliman_frame &frame) noexcept {
    return static_cast<size_t>(frame.rows * frame.cols) * (frame.pixel == TOLIMAN_PIXEL_U32 ? 4 : 2);
}

bool is_raw(const toliman_frame &frame) noexcept {
    const bool is_contiguous = frame.stride == 0 || frame.stride == frame.cols;
    return is_contiguous && (frame.pixel == TOLIMAN_PIXEL_U16 || frame.pixel == TOLIMAN_PIXEL_U32);
}

} // namespace

int32_t Realigner::call(const toliman_frame *frame, const toliman_track_outcome *, toliman_frame *other,
                        void *realigner) noexcept {
    try {
        return static_cast<Realigner *>(realigner)->find(*frame, *other);
    } catch (...) { // the file has changed: the frame stays a misfit
        return 0;
    }
}

void Realigner::begin() noexcept {
    origins_.clear();
    found_.clear();
}

void Realigner::expect(const toliman_frame &frame, const std::shared_ptr<FrameSource> &source, int64_t offset) {
    origins_[frame.pixels] = {source, offset, 0};
}

int64_t Realigner::shift_of(const toliman_frame &frame) const {
    const auto origin = origins_.find(frame.pixels);
    return origin != origins_.end() ? origin->second.shift : 0;
}

void Realigner::settle(const toliman_frame &frame, bool is_good, bool is_known) {
    const auto origin = origins_.find(frame.pixels);
    const bool was_moved = origin != origins_.end() && origin->second.shift != 0;
    if ((is_good || is_known) && was_moved)
        origin->second.source->set_shift(origin->second.shift);
    if (was_moved || !is_raw(frame) || !(is_good || (is_known && pixels_.empty())))
        return;
    reference_ = frame;
    pixels_.resize(bytes_of(frame));
    std::memcpy(pixels_.data(), frame.pixels, pixels_.size());
    reference_.pixels = pixels_.data();
}

int32_t Realigner::find(const toliman_frame &frame, toliman_frame &other) {
    const auto origin = origins_.find(frame.pixels);
    const bool is_like_reference = !pixels_.empty() && is_raw(frame) && frame.pixel == reference_.pixel &&
                                   frame.rows == reference_.rows && frame.cols == reference_.cols;
    if (origin == origins_.end() || !is_like_reference)
        return 0;
    found_.emplace_back(pixels_.size());
    origin->second.shift = origin->second.source->find(origin->second.offset, reference_, found_.back());
    if (origin->second.shift == 0)
        return 0;
    other.pixels = found_.back().data();
    return 1;
}

} // namespace cli
