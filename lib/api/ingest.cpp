// include/toliman/ingest.h: pairs of files and batches
#include <toliman/ingest.h>

#include "api/common.hpp"
#include "api/pixel_frames.hpp"
#include "api/spread.hpp"
#include "api/track_frames.hpp"
#include "backend/netcdf.hpp"
#include "base/name.hpp"
#include "ingest/batch.hpp"
#include "ingest/pair.hpp"

using namespace toliman;
using namespace toliman::api;

struct toliman_ingest : Handle<toliman_ingest> {
    static constexpr char kType[] = "toliman_ingest";
    toliman_ingest_options options; // its allocator may be gone
    ingest::ReaderOptions reader_options;
    std::unique_ptr<ingest::Reader> reader;
    std::vector<toliman_spread> spreads; // of the frames that are valid
    size_t next_spread = 0;
};

namespace {

constexpr Choice<ingest::EventKind> kEvents = {TOLIMAN_INGEST_EVENT_NOTHING, TOLIMAN_INGEST_EVENT_WARNING,
                                               "TOLIMAN_INGEST_EVENT_..."};
constexpr Choice<ingest::Reason> kReasons = {TOLIMAN_INGEST_REASON_NONE, TOLIMAN_INGEST_REASON_UNKNOWN_KEY,
                                             "TOLIMAN_INGEST_REASON_..."};

// From a time stamp to the middle of the exposure, in halves of its length.
int middle_of(const toliman_ingest_options &options) {
    const track::Stamp stamp = kStamps.to_enum(options.stamp);
    return stamp == track::Stamp::start ? 1 : stamp == track::Stamp::end ? -1 : 0;
}

void check_shape(const toliman_ingest_options &options) {
    if ((options.rows == 0) != (options.cols == 0))
        fail(Status::argument, "{options->%s} = 0: rows and cols must both be 0 or in [1, %lld]",
             options.rows == 0 ? "rows" : "cols", static_cast<long long>(kLargestSide));
}

void check(const toliman_ingest_options &options) {
    if (options.pixel != 0 && options.pixel != TOLIMAN_PIXEL_U16 && options.pixel != TOLIMAN_PIXEL_U32)
        fail(Status::argument, "{options->pixel} = %d: must be TOLIMAN_PIXEL_U16, %d, TOLIMAN_PIXEL_U32, %d, or 0",
             options.pixel, TOLIMAN_PIXEL_U16, TOLIMAN_PIXEL_U32);
    check_shape(options);
    const bool has_range = options.first_id != 0 || options.end_id != 0;
    if (has_range && options.first_id >= options.end_id)
        fail(Status::argument, "{options->end_id} = %lld: must be above first_id, %lld, or both 0 for all frames",
             static_cast<long long>(options.end_id), static_cast<long long>(options.first_id));
    if (options.roi != nullptr && !is_name(options.roi))
        fail(Status::argument, "{options->roi} = \"%.64s\": %s", options.roi, kNameRule);
}

toliman_ingest_options known_options(const toliman_ingest_options *given, bool is_batch) {
    required(given, "options");
    const toliman_ingest_options options = accept(given, "options");
    if (is_batch && options.pixel == TOLIMAN_PIXEL_U32)
        fail(Status::argument, "{options->pixel} = %d: must be TOLIMAN_PIXEL_U16, %d, or 0, for a batch", options.pixel,
             TOLIMAN_PIXEL_U16);
    check(options);
    return options;
}

ingest::ReaderOptions reader_options(const toliman_ingest_options &options) {
    ingest::ReaderOptions pair;
    pair.growing = (options.flags & TOLIMAN_INGEST_GROWING) != 0;
    pair.pixel_bytes = options.pixel != 0 ? size_of(kPixels.to_enum(options.pixel)) : 0;
    pair.middle = middle_of(options);
    TOLIMAN_COPY(pair, options, exposure_s, rows, cols);
    if (options.first_id != 0 || options.end_id != 0)
        pair.ids = {options.first_id, options.end_id};
    pair.roi = options.roi != nullptr ? options.roi : "";
    pair.buffers = options.buffers;
    return pair;
}

std::unique_ptr<ingest::Reader> reader_of(const char *path, const ingest::ReaderOptions &options) {
    if (ingest::is_batch(path))
        return std::make_unique<ingest::Batch>(path, options);
    return std::make_unique<ingest::Pair>(path, options);
}

// Of the frames of a reader; 0 if it is not known yet.
int32_t pixel_of(const ingest::Reader &reader) noexcept {
    const size_t bytes = reader.pixel_bytes();
    return bytes == 0 ? 0 : bytes == sizeof(uint32_t) ? TOLIMAN_PIXEL_U32 : TOLIMAN_PIXEL_U16;
}

toliman_frame public_frame(const ingest::Event &event, int32_t pixel, const ingest::ReaderOptions &reader) {
    toliman_frame frame = {};
    const ingest::SideLine &line = event.line;
    TOLIMAN_COPY(frame, line, session, roi, frame_id, restarts);
    if (line.rows == 0) // no valid line
        return frame;
    frame.camera_ns = line.stamp_ns + line.clock_shift_ns + ingest::shift_of(line, reader);
    TOLIMAN_COPY(frame, line, dropped, rows, cols);
    if (event.kind != ingest::EventKind::frame)
        return frame;
    frame.pixel = pixel;
    frame.pixels = event.pixels;
    frame.exposure_s = ingest::exposure_of(line, reader);
    TOLIMAN_COPY(frame, line, window_row, window_col);
    if (line.on_target_s) {
        frame.intervals = line.on_target_s->data();
        frame.interval_count = line.on_target_s->size() / 2;
    }
    return frame;
}

toliman_ingest_event public_event(const ingest::Event &event) {
    toliman_ingest_event result = {};
    result.event = kEvents.to_constant(event.kind);
    result.reason = kReasons.to_constant(event.reason);
    TOLIMAN_COPY(result, event.line, has_key, stamp_ns, host_s);
    result.file = event.file->c_str();
    result.line = event.number;
    TOLIMAN_COPY(result, event, text, offset);
    return result;
}

} // namespace

extern "C" {

toliman_status toliman_ingest_create(const char *path, const toliman_ingest_options *options,
                                     toliman_ingest **out) noexcept {
    return guard([&] {
        required(path, "path");
        toliman_ingest *&made = required(out, "out");
        const toliman_ingest_options known = known_options(options, ingest::is_batch(path));
        const MemoryScope scope(memory_of(known.allocator));
        const ingest::ReaderOptions wanted = reader_options(known);
        made =
            new toliman_ingest{{}, known, wanted, reader_of(path, wanted), std::vector<toliman_spread>(wanted.buffers)};
        made->options.roi = nullptr; // the caller's
    });
}

void toliman_ingest_destroy(toliman_ingest *ingest) noexcept {
    destroy(ingest);
}

toliman_status toliman_ingest_next(toliman_ingest *ingest, toliman_frame *frame, toliman_ingest_event *event) noexcept {
    return call(ingest, "ingest", [&](auto &self) {
        check_struct_size("frame", required(frame, "frame"));
        check_struct_size("event", required(event, "event"));
        const ingest::Event found = self.reader->next();
        toliman_frame out = public_frame(found, pixel_of(*self.reader), self.reader_options);
        if (found.kind == ingest::EventKind::frame && found.line.spread) {
            toliman_spread &spread = self.spreads[self.next_spread++ % self.spreads.size()];
            spread = public_spread(*found.line.spread);
            out.spread = &spread;
        }
        deliver(out, frame, "frame");
        deliver(public_event(found), event, "event");
    });
}

toliman_status toliman_ingest_find_frame(const toliman_ingest *ingest, int64_t offset, const toliman_frame *reference,
                                         void *pixels, size_t size, int64_t *shift) noexcept {
    return call(ingest, "ingest", [&](auto &self) {
        if (offset < 0)
            fail(Status::argument, "{offset} = %lld: must be at least 0", static_cast<long long>(offset));
        const toliman_frame known = copied(&required(reference, "reference"), "reference");
        required(pixels, "pixels");
        required(shift, "shift");
        if (known.pixel != pixel_of(*self.reader) || known.rows < 1 || known.cols < 1 || known.rows > kLargestSide ||
            known.cols > kLargestSide || (known.stride != 0 && known.stride != known.cols))
            fail(Status::argument, "{reference}: must be a contiguous frame of the pixel type of the reader");
        const auto count = static_cast<size_t>(known.rows * known.cols);
        const size_t needed = count * size_of(kPixels.to_enum(known.pixel, "reference->pixel"));
        if (size < needed)
            fail(Status::capacity, "{size} = %zu: must be at least %zu, the bytes of the reference", size, needed);
        *shift = self.reader->find(static_cast<uint64_t>(offset), count,
                                   &required(static_cast<const char *>(known.pixels), "reference->pixels"), pixels);
    });
}

toliman_status toliman_ingest_set_shift(toliman_ingest *ingest, int64_t shift) noexcept {
    return call(ingest, "ingest", [&](auto &self) { self.reader->set_shift(shift); });
}

toliman_status toliman_ingest_finish(toliman_ingest *ingest) noexcept {
    return call(ingest, "ingest", [&](auto &self) { self.reader->finish(); });
}

const char *toliman_ingest_netcdf_version(void) noexcept {
    try {
        return netcdf::version();
    } catch (...) { // out of memory
        return "";
    }
}

toliman_status toliman_ingest_get_info(const toliman_ingest *ingest, toliman_ingest_info *out) noexcept {
    return query(ingest, "ingest", out, [&](auto &self, auto &info) {
        const ingest::ReaderCounts counts = self.reader->counts();
        TOLIMAN_COPY(info, self.options, stamp, exposure_s);
        TOLIMAN_COPY(info, counts, lines, frames, damaged, warnings, skipped, bytes);
        info.pixel = pixel_of(*self.reader);
        info.side_file = self.reader->side_path().c_str();
        info.pixel_file = self.reader->pixel_path().c_str();
    });
}

} // extern "C"
