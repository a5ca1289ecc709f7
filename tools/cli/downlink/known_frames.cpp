// Method: ranges of consecutive ids, in any order of arrival. Frames that the camera dropped are gaps of a few ids, of
// which a day may have 10^5; a file that has not arrived is a gap of thousands. Beyond kMostRanges, the smallest gap is
// closed, the first of equal ones: a frame that arrives for it afterwards is taken for known.
#include "downlink/known_frames.hpp"

#include <algorithm>
#include <charconv>
#include <cinttypes>
#include <cstdio>
#include <stdexcept>

#include "frames/frames_in.hpp"

namespace cli {

namespace {

constexpr size_t kMostRanges = 1024; // of a source

} // namespace

FrameKey::FrameKey(const toliman_frame &frame, const toliman_ingest_event &event)
    : source(frame.session), id(frame.frame_id) {
    if (!is_dated_file(event.file)) {
        source += "/" + std::to_string(frame.restarts) + "/" + frame.roi;
        return;
    }
    const size_t start = source.find_last_not_of("0123456789") + 1, digits = source.size() - start; // of the number
    id = 0;
    if (std::from_chars(source.data() + start, source.data() + source.size(), id).ec == std::errc())
        source = source.substr(0, start) + "#" + std::to_string(digits); // 7 is not 07
    source += "/" + std::to_string(event.line);
}

bool KnownFrames::contains(const FrameKey &key) const {
    const auto known = sources_.find(key.source);
    if (known == sources_.end())
        return false;
    const auto next = known->second.upper_bound(key.id);
    return next != known->second.begin() && std::prev(next)->second >= key.id;
}

void KnownFrames::insert(const FrameKey &key) {
    Ranges &ranges = sources_[key.source];
    insert(ranges, key.id, key.id);
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
    for (const auto &[source, ranges] : sources_) {
        std::string text;
        for (const auto &[first, last] : ranges)
            text += (text.empty() ? "" : " ") + std::to_string(first) + "-" + std::to_string(last);
        all.set(source.c_str(), text);
    }
    return all;
}

void KnownFrames::read(const cJSON *object) {
    if (!cJSON_IsObject(object))
        throw std::invalid_argument("no object");
    for (const cJSON *item = object->child; item != nullptr; item = item->next) {
        Ranges &ranges = sources_[item->string];
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
