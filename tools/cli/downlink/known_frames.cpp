// Method: ranges of consecutive ids, in any order of arrival. Frames that the camera dropped are gaps of a few ids, of
// which a day may have 10^5; a file that has not arrived is a gap of thousands. Beyond kMostRanges, the smallest gap is
// closed, the first of equal ones: a frame that arrives for it afterwards is taken for known.
#include "downlink/known_frames.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <stdexcept>

namespace cli {

namespace {

constexpr size_t kMostRanges = 1024; // of a key

std::string key_of(const toliman_frame &frame) {
    return std::string(frame.session) + "/" + std::to_string(frame.restarts) + "/" + frame.roi;
}

} // namespace

bool KnownFrames::contains(const toliman_frame &frame) const {
    const auto key = keys_.find(key_of(frame));
    if (key == keys_.end())
        return false;
    const auto next = key->second.upper_bound(frame.frame_id);
    return next != key->second.begin() && std::prev(next)->second >= frame.frame_id;
}

void KnownFrames::insert(const toliman_frame &frame) {
    Ranges &ranges = keys_[key_of(frame)];
    insert(ranges, frame.frame_id, frame.frame_id);
    if (ranges.size() > kMostRanges)
        close_smallest_gap(ranges);
}

// Unites the range with those that overlap or touch it.
void KnownFrames::insert(Ranges &ranges, int64_t first, int64_t last) {
    const auto touch = [](int64_t end, int64_t begin) { return begin <= end || begin - 1 == end; };
    auto at = ranges.upper_bound(first);
    if (at != ranges.begin() && touch(std::prev(at)->second, first))
        --at;
    while (at != ranges.end() && touch(last, at->first)) {
        first = std::min(first, at->first);
        last = std::max(last, at->second);
        at = ranges.erase(at);
    }
    ranges.emplace(first, last);
}

void KnownFrames::close_smallest_gap(Ranges &ranges) {
    auto best = ranges.begin();
    uint64_t least = UINT64_MAX;
    for (auto at = ranges.begin(), next = std::next(at); next != ranges.end(); at = next++) {
        const uint64_t gap = static_cast<uint64_t>(next->first) - static_cast<uint64_t>(at->second);
        if (gap < least) {
            least = gap;
            best = at;
        }
    }
    best->second = std::next(best)->second;
    ranges.erase(std::next(best));
}

Json KnownFrames::json() const {
    Json all;
    for (const auto &[key, ranges] : keys_) {
        std::string text;
        for (const auto &[first, last] : ranges)
            text += (text.empty() ? "" : " ") + std::to_string(first) + "-" + std::to_string(last);
        all.set(key.c_str(), text);
    }
    return all;
}

void KnownFrames::read(const cJSON *object) {
    if (!cJSON_IsObject(object))
        throw std::invalid_argument("no object");
    for (const cJSON *item = object->child; item != nullptr; item = item->next) {
        Ranges &ranges = keys_[item->string];
        const char *text = cJSON_IsString(item) ? item->valuestring : "-";
        while (*text != '\0') {
            int64_t first = 0, last = 0;
            int size = 0;
            if (std::sscanf(text, "%" SCNd64 "-%" SCNd64 "%n", &first, &last, &size) != 2 || first > last)
                throw std::invalid_argument(item->string);
            insert(ranges, first, last);
            text += size;
        }
    }
}

} // namespace cli
