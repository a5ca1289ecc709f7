/* libtoliman, tracking: which downlinked frame is new.
 *
 * A frame is (session, frame id, region of interest): packet counters wrap and times repeat. The same frame may arrive
 * again after a lost confirmation, and must then not count twice; the same key with other pixels is a conflict.
 */
#ifndef TOLIMAN_TRACK_H
#define TOLIMAN_TRACK_H

#include <toliman/base.h>

TOLIMAN_BEGIN_DECLS

/* Index of the frames seen so far. Since 0.1. */
typedef struct toliman_track toliman_track;

#define TOLIMAN_TRACK_NEW 0       /* first time seen */
#define TOLIMAN_TRACK_DUPLICATE 1 /* seen with the same bytes */
#define TOLIMAN_TRACK_CONFLICT 2  /* seen with other bytes; stays so for every later arrival of the key */

/* Index for at most `capacity` frames, 1 ... 2^32; 36 bytes a frame, all taken here. The caller destroys *out.
 * Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_create(int64_t capacity,
                                                                   toliman_track **out) TOLIMAN_NOEXCEPT;

/* Ends an index; NULL is allowed. Since 0.1. */
TOLIMAN_API void toliman_track_destroy(toliman_track *track) TOLIMAN_NOEXCEPT;

/* Takes note of a frame and says which of the three it is. session and roi match [A-Za-z0-9._-]{1,64} and do not begin
 * with a dot (TOLIMAN_E_ARGUMENT); bytes[size] are its pixels as received, compared by CRC32 and size. A new frame
 * beyond the capacity is TOLIMAN_E_CAPACITY. Since 0.1. */
TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_track_push(toliman_track *track, const char *session,
                                                                 int64_t frame_id, const char *roi, const void *bytes,
                                                                 size_t size, int32_t *verdict) TOLIMAN_NOEXCEPT;

/* Different keys seen so far; 0 for NULL. Since 0.1. */
TOLIMAN_API int64_t toliman_track_count(const toliman_track *track) TOLIMAN_NOEXCEPT;

TOLIMAN_END_DECLS

#endif
