// include/toliman/ingest.h: clock tables, leap seconds, dates
#include <toliman/ingest.h>

#include "api/guard.hpp"

using namespace toliman;
using namespace toliman::api;

extern "C" {

toliman_status toliman_ingest_read_clock(const char *, int64_t *, size_t, size_t *, toliman_log_fn, void *) noexcept {
    return guard([&] { fail(Status::unsupported, "clock tables: not yet supported"); });
}

toliman_status toliman_ingest_read_leap_seconds(const char *, toliman_leap_second *, size_t, size_t *,
                                                int64_t *) noexcept {
    return guard([&] { fail(Status::unsupported, "leap seconds: not yet supported"); });
}

toliman_status toliman_ingest_parse_time(const char *, int32_t, int32_t, const toliman_leap_second *, size_t,
                                         int64_t *) noexcept {
    return guard([&] { fail(Status::unsupported, "dates: not yet supported"); });
}

toliman_status toliman_ingest_convert_times(const int64_t *, size_t, int32_t, const toliman_leap_second *, size_t,
                                            int64_t *) noexcept {
    return guard([&] { fail(Status::unsupported, "dates: not yet supported"); });
}

} // extern "C"
