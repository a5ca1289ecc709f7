// Method: the file of pixels has no header, so the lines of the side file must give the position of each frame. A
// malformed line counts as a frame of the expected shape. If the frames of all lines fill the file exactly, each line
// is where the sum of those before it ends. If frames of the expected shape fill it, lines of other shapes are wrong.
// Otherwise positions are known only before the first line that is malformed or of another shape than the first: what
// follows may be shifted. Only sums are kept, so that a line costs the same at any length of the file.
#include "ingest/placement.hpp"

namespace toliman::ingest {

uint64_t Placement::pixels(const SideLine &line) const noexcept {
    const bool valid = line.error.empty();
    return valid ? uint64_t{line.rows} * line.cols : usual_pixels_;
}

void Placement::add(Sums &sums, const SideLine &line) const noexcept {
    sums.lines++;
    if (line.error.empty())
        sums.valid_pixels += pixels(line);
    else
        sums.bad++;
}

void Placement::count(const SideLine &line) noexcept {
    if (usual_pixels_ == 0 && line.error.empty())
        usual_pixels_ = pixels(line);
    if (all_.lines == 0)
        first_pixels_ = pixels(line);
    add(all_, line);
}

void Placement::release(const SideLine &line) noexcept {
    has_odd_ = has_odd_ || is_odd(line);
    add(done_, line);
}

void Placement::set_size(uint64_t size) noexcept {
    size_ = size;
    is_exact_ = bytes(all_) == size;
    is_uniform_ = !is_exact_ && static_cast<uint64_t>(all_.lines) * usual_pixels_ * pixel_bytes_ == size;
}

void Placement::set_shift(int64_t bytes) noexcept {
    shift_ = is_exact_ || is_uniform_ ? 0 : bytes;
}

bool Placement::is_odd(const SideLine &line) const noexcept {
    return !line.error.empty() || pixels(line) != first_pixels_;
}

std::optional<Place> Placement::next(const SideLine &line) const noexcept {
    if (is_uniform_)
        return Place{static_cast<uint64_t>(done_.lines) * usual_pixels_ * pixel_bytes_, usual_pixels_ * pixel_bytes_};
    const Place place = {bytes(done_), bytes(line)};
    const int64_t end = static_cast<int64_t>(place.offset + place.bytes) + shift_;
    if (is_exact_ || (!has_odd_ && !is_odd(line) && end <= static_cast<int64_t>(size_)))
        return place;
    return std::nullopt;
}

} // namespace toliman::ingest
