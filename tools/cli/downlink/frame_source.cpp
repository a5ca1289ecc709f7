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

PairSource::PairSource(const std::string &path, const toliman_ingest_options &options) {
    toliman_ingest *reader = nullptr;
    check_input(toliman_ingest_create(path.c_str(), &options, &reader));
    reader_.reset(reader);
}

bool PairSource::next(toliman_frame &frame, toliman_ingest_event &event) {
    frame = toliman::sized<toliman_frame>();
    event = toliman::sized<toliman_ingest_event>();
    check_input(toliman_ingest_next(reader_.get(), &frame, &event));
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

void PairSource::finish() {
    toliman::check(toliman_ingest_finish(reader_.get()));
}

} // namespace cli
