#include "frames/frame_source.hpp"

#include <algorithm>
#include <utility>

#include "common/failure.hpp"
#include "common/library.hpp"

namespace cli {

FileSource::FileSource(std::unique_ptr<FrameFile> file, size_t buffers, Label label)
    : file_(std::move(file)), label_(std::move(label)),
      buffers_(std::min(std::max<size_t>(buffers, 1), file_->count())) {}

bool FileSource::next(toliman_frame &frame, toliman_ingest_event &event) {
    for (; file_->more(); skipped_++, file_->skip()) {
        frame = toliman::sized<toliman_frame>();
        const size_t k = frame_++;
        if (!label_(k, frame))
            continue;
        std::vector<double> &pixels = buffers_[next_++ % buffers_.size()];
        pixels.resize((file_->frame_size() + sizeof(double) - 1) / sizeof(double));
        file_->read(pixels.data());
        frame.pixel = file_->pixel();
        frame.pixels = pixels.data();
        frame.rows = static_cast<int64_t>(file_->rows());
        frame.cols = static_cast<int64_t>(file_->cols());
        event = toliman::sized<toliman_ingest_event>();
        event.event = TOLIMAN_INGEST_EVENT_FRAME;
        event.reason = TOLIMAN_INGEST_REASON_NONE;
        event.has_key = 1;
        event.file = file_->path().c_str();
        event.line = static_cast<int64_t>(k);
        event.text = "";
        return true;
    }
    return false;
}

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
    return info_from<toliman_ingest_info>(toliman_ingest_get_info, reader_.get()).skipped;
}

void PairSource::finish() {
    toliman::check(toliman_ingest_finish(reader_.get()));
}

std::string place_of(const char *file, int32_t event, int64_t line) {
    const bool is_frame = event == TOLIMAN_INGEST_EVENT_FRAME; // the first of a file has index 0
    return is_frame || line > 0 ? std::string(file) + ":" + std::to_string(line) : file;
}

} // namespace cli
