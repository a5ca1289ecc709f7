// Method: ranges of consecutive ids, in any order of arrival. Ids that the camera dropped before a frame join its range
// where they are just the gap to the range before: no frame has them. Other gaps remain, as their frames may arrive.
#include "downlink/known_frames.hpp"

#include <charconv>
#include <cinttypes>
#include <stdexcept>

#include "frames/frames_in.hpp"

namespace cli {

FrameKey::FrameKey(const toliman_frame &frame, const toliman_ingest_event &event)
    : source(frame.session), id(frame.frame_id), dropped(frame.dropped) {
    if (!is_dated_file(event.file)) {
        source += "/" + std::to_string(frame.restarts) + "/" + frame.roi;
        return;
    }
    dropped = 0;
    id = event.line;
    const size_t start = source.find_last_not_of("0123456789") + 1, digits = source.size() - start; // of the number
    int64_t number = 0;
    const auto read = std::from_chars(source.data() + start, source.data() + source.size(), number);
    if (event.line > 0 || read.ec != std::errc()) {
        source += "/";
        return;
    }
    id = number;
    source = source.substr(0, start) + "#" + std::to_string(digits); // 7 is not 07
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
    const auto next = ranges.lower_bound(key.id);
    int64_t first = key.id; // of the ids that were dropped
    const bool is_gap = next != ranges.begin() && !__builtin_sub_overflow(key.id, key.dropped, &first) &&
                        first == std::prev(next)->second + 1;
    insert(ranges, is_gap ? first : key.id, key.id);
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
