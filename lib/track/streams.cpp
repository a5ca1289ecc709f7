#include "track/streams.hpp"

#include <algorithm>

#include "base/error.hpp"

namespace toliman::track {

Streams::Streams(int64_t frames)
    : most_(std::min(static_cast<size_t>(frames), kMax)), streams_(most_ + most_ / 2 + 1) {}

size_t Streams::slot_of(uint64_t stream) const noexcept {
    size_t at = scatter_.slot(stream, streams_.size());
    while (!streams_[at].empty() && streams_[at].digest != stream)
        at = at + 1 < streams_.size() ? at + 1 : 0;
    return at;
}

void Streams::check_capacity(uint64_t stream) const {
    if (count_ == most_ && streams_[slot_of(stream)].empty())
        fail(Status::capacity, "too many sessions and regions: capacity = %zu", count_);
}

void Streams::add(uint64_t stream, int64_t frame_id) noexcept {
    StreamCount &known = streams_[slot_of(stream)];
    const Wide before = known.ids();
    if (known.empty()) {
        known.digest = stream;
        known.first = known.last = frame_id;
        count_++;
    }
    known.first = std::min(known.first, frame_id);
    known.last = std::max(known.last, frame_id);
    ids_ += known.ids() - before;
    known.frames++;
}

void Streams::set_named(uint64_t stream) noexcept {
    StreamCount &known = streams_[slot_of(stream)];
    known.named = !known.empty();
}

std::vector<StreamCount> Streams::all() const {
    std::vector<StreamCount> all;
    for (const StreamCount &stream : streams_)
        if (!stream.empty())
            all.push_back(stream);
    return all;
}

int64_t Streams::expected() const noexcept {
    return ids_ > INT64_MAX ? INT64_MAX : static_cast<int64_t>(ids_);
}

} // namespace toliman::track
