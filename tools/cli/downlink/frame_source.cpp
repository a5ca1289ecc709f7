#include "downlink/frame_source.hpp"

namespace cli {

namespace {

// Errors of the files end their input only.
void check_input(toliman_status status) {
    if (status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_NOT_FOUND)
        throw Failure(kExitInput, toliman_last_error());
    toliman::check(status);
}

} // namespace

std::string place_of(const toliman_ingest_event &event) {
    const bool is_frame = event.event == TOLIMAN_INGEST_EVENT_FRAME; // the first of a file has index 0
    return is_frame || event.line > 0 ? std::string(event.file) + ":" + std::to_string(event.line) : event.file;
}

PairSource::PairSource(const std::string &path, const toliman_ingest_options &options, uint32_t bit_depth)
    : bit_depth_(bit_depth) {
    toliman_ingest *reader = nullptr;
    check_input(toliman_ingest_create(path.c_str(), &options, &reader));
    reader_.reset(reader);
}

bool PairSource::next(toliman_frame &frame, toliman_ingest_event &event) {
    frame = toliman::sized<toliman_frame>();
    event = toliman::sized<toliman_ingest_event>();
    check_input(toliman_ingest_next(reader_.get(), &frame, &event));
    if (frame.pixels != nullptr && !suits(frame.pixel, bit_depth_)) {
        const bool wide = frame.pixel == TOLIMAN_PIXEL_U32;
        const std::string here = wide ? "u32le" : "u16le", other = wide ? "u16le" : "u32le",
                          depth = std::to_string(bit_depth_);
        malformed(event.file, "has pixels of " + here + ", but the frames of the state folder have " + depth +
                                  " bits: use another folder, --dtype " + other +
                                  " if they are of that type, or --bit-depth " + depth + " if they have as many bits");
    }
    return event.event != TOLIMAN_INGEST_EVENT_NOTHING;
}

int64_t PairSource::skipped() const {
    return toliman::result<toliman_ingest_info>(toliman_ingest_get_info, reader_.get()).skipped;
}

int64_t PairSource::find(int64_t offset, const toliman_frame &reference, std::vector<uint8_t> &pixels) const {
    int64_t shift = 0;
    check_input(toliman_ingest_find_frame(reader_.get(), offset, &reference, pixels.data(), pixels.size(), &shift));
    return shift;
}

void PairSource::set_shift(int64_t bytes) {
    toliman::check(toliman_ingest_set_shift(reader_.get(), bytes));
}

int32_t PairSource::pixel() const {
    return toliman::result<toliman_ingest_info>(toliman_ingest_get_info, reader_.get()).pixel;
}

void PairSource::finish() {
    toliman::check(toliman_ingest_finish(reader_.get()));
}

} // namespace cli
