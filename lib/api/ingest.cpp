// include/toliman/ingest.h: pairs of files
#include <toliman/ingest.h>

#include "api/guard.hpp"
#include "api/handle.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_ingest : Handle<toliman_ingest> {
    static constexpr char kType[] = "toliman_ingest";
};

extern "C" {

void toliman_ingest_options_init(toliman_ingest_options *options, size_t size) noexcept {
    deliver_defaults(toliman_ingest_options{}, options, size);
}

toliman_status toliman_ingest_create(const char *, const toliman_ingest_options *, toliman_ingest **) noexcept {
    return guard([&] { fail(Status::unsupported, "pairs of files: not yet supported"); });
}

void toliman_ingest_destroy(toliman_ingest *ingest) noexcept {
    destroy(ingest);
}

const char *toliman_ingest_reason_name(int32_t) noexcept {
    return "?";
}

toliman_status toliman_ingest_next(toliman_ingest *, toliman_frame *, toliman_ingest_event *) noexcept {
    return guard([&] { fail(Status::unsupported, "pairs of files: not yet supported"); });
}

toliman_status toliman_ingest_finish(toliman_ingest *) noexcept {
    return guard([&] { fail(Status::unsupported, "pairs of files: not yet supported"); });
}

toliman_status toliman_ingest_get_info(const toliman_ingest *, toliman_ingest_info *) noexcept {
    return guard([&] { fail(Status::unsupported, "pairs of files: not yet supported"); });
}

} // extern "C"
