// include/toliman/track.h
#include <toliman/track.h>

#include "api/guard.hpp"
#include "backend/zip.hpp"
#include "track/identity.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_track {
    track::FrameIndex index;
};

static_assert(static_cast<int32_t>(track::Verdict::fresh) == TOLIMAN_TRACK_NEW &&
              static_cast<int32_t>(track::Verdict::duplicate) == TOLIMAN_TRACK_DUPLICATE &&
              static_cast<int32_t>(track::Verdict::conflict) == TOLIMAN_TRACK_CONFLICT);

extern "C" {

toliman_status toliman_track_create(int64_t capacity, toliman_track **out) noexcept {
    return guard([&] {
        required(out, "out");
        *out = new toliman_track{track::FrameIndex(capacity)};
    });
}

void toliman_track_destroy(toliman_track *track) noexcept {
    delete track;
}

toliman_status toliman_track_push(toliman_track *track, const char *session, int64_t frame_id, const char *roi,
                                  const void *bytes, size_t size, int32_t *verdict) noexcept {
    return guard([&] {
        required(track, "track");
        track::check_name(&required(session, "session"), "session");
        track::check_name(&required(roi, "roi"), "roi");
        required(bytes, "bytes");
        required(verdict, "verdict");
        const track::Content content = {size, zip::crc32(bytes, size)};
        *verdict = static_cast<int32_t>(track->index.push(track::key_digest(session, frame_id, roi), content));
    });
}

int64_t toliman_track_count(const toliman_track *track) noexcept {
    return track != nullptr ? track->index.count() : 0;
}

} // extern "C"
