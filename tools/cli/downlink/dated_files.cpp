#include "downlink/dated_files.hpp"

#include <algorithm>
#include <cstring>
#include <tuple>
#include <utility>

#include "base/name.hpp"
#include "common/failure.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

// The file's name without folder and suffix.
std::string name_of(const std::string &path) {
    std::string name = path.substr(path.rfind('/') + 1);
    for (const char *suffix : {".npy", ".fits", ".fits.fz", ".fits.gz"})
        if (ends_with(name, suffix))
            return name.substr(0, name.size() - std::strlen(suffix));
    return name;
}

// event.line is the index of the frame in the file, from 0.
class DatedFile : public FrameSource {
  public:
    // first_id: of the first frame. Frames with other ids than the wanted ones are skipped.
    DatedFile(std::unique_ptr<FrameFile> file, size_t buffers, const std::string &session, int64_t first_id,
              const FrameTimes &times, const FrameIds &wanted)
        : file_(std::move(file)), buffers_(std::min(buffers, file_->count())), session_(session), first_id_(first_id),
          times_(times), wanted_(wanted) {}
    int64_t skipped() const override { return skipped_; }

    bool next(toliman_frame &frame, toliman_ingest_event &event) override {
        for (; file_->more(); skipped_++, file_->skip()) {
            const size_t k = frame_++;
            frame = toliman::sized<toliman_frame>();
            frame.frame_id = first_id_ + static_cast<int64_t>(k);
            if (!wanted_.contains(frame.frame_id))
                continue;
            std::vector<double> &pixels = buffers_[next_++ % buffers_.size()];
            pixels.resize((file_->frame_size() + sizeof(double) - 1) / sizeof(double));
            file_->read(pixels.data());
            frame.session = session_.c_str();
            frame.roi = "single_roi"; // the mission's name of the only region
            frame.camera_ns = times_.at(k);
            frame.exposure_s = times_.exposure_s();
            const FrameWindow window = file_->window(k).value_or(FrameWindow());
            frame.window_row = window[0];
            frame.window_col = window[1];
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

  private:
    std::unique_ptr<FrameFile> file_;
    std::vector<std::vector<double>> buffers_; // of doubles, which are aligned for every type
    std::string session_;
    int64_t first_id_, skipped_ = 0;
    FrameTimes times_;
    FrameIds wanted_;
    size_t next_ = 0, frame_ = 0; // buffer and frame that come next
};

} // namespace

// Files of one session are distinguished by their key FRAME1 or SEQNUM, never by the order in which they arrive.
DatedFiles::Span DatedFiles::span_of(FrameFile &file) {
    const std::string &path = file.path(), &given = options_.session,
                      session = options_.one_session ? "files"
                                : given.empty()      ? name_of(path)
                                                     : given;
    const std::optional<int64_t> number = file.first_id();
    if (!toliman::is_name(session))
        malformed(path,
                  "session " + session + ": must have 1 to 64 characters A-Z a-z 0-9 . _ - and not begin with a dot");
    if (!given.empty() && !number) {
        if (!unnumbered_.empty() && unnumbered_ != path)
            malformed(path, "has no key FRAME1 or SEQNUM, the number of its first frame: --session " + session +
                                " cannot distinguish it from " + unnumbered_);
        unnumbered_ = path;
    }
    const int64_t first_id = number.value_or(0);
    return {path, session, first_id, first_id + static_cast<int64_t>(file.count()) - 1};
}

FrameTimes DatedFiles::times_of(FrameFile &file, const Span &span) {
    const int64_t time_zero_ns = options_.begins_at_epoch ? sink_.settings().grid.time_offset_ns : 0;
    FrameTimes times(file, span.first_id, options_.cadence, options_.leap_seconds, time_zero_ns);
    const std::string &path = file.path();
    if (times.is_tai() && sink_.settings().clock.count > 0)
        throw Failure(kExitUsage,
                      path + ": its time (" + times.rule() +
                          ") is TAI, but the state folder has a clock table: give a folder without --clock");
    if (is_fits(path))
        sink_.report(times.is_assumed() ? Severity::warning : Severity::note, "time", path, "time by " + times.rule());
    if (times.by_cadence())
        warn_of_overlap(span, times);
    return times;
}

// The same frames again have the same times.
void DatedFiles::warn_of_overlap(Span span, const FrameTimes &times) {
    span.first_ns = times.at(0);
    span.last_ns = times.at(static_cast<size_t>(span.last_id - span.first_id));
    const auto has_frames = [&span](const Span &other) {
        return span.session == other.session && span.first_id <= other.last_id && other.first_id <= span.last_id;
    };
    const auto overlaps = [&span](const Span &other) {
        return span.first_ns <= other.last_ns && other.first_ns <= span.last_ns;
    };
    if (std::any_of(spans_.begin(), spans_.end(), has_frames))
        return;
    const auto other = std::find_if(spans_.begin(), spans_.end(), overlaps);
    if (other != spans_.end())
        sink_.report(Severity::warning, "same times", span.path,
                     "its times by --cadence overlap those of " + other->path +
                         ": FRAME1 or a time in the header of a FITS file distinguishes them");
    spans_.push_back(span);
}

std::shared_ptr<FrameSource> DatedFiles::open(const std::string &path, const FrameIds &wanted) {
    auto file = open_frames(path, "", 0, 0, options_.unit);
    const Span span = span_of(*file);
    const FrameTimes times = times_of(*file, span);
    return std::make_shared<DatedFile>(std::move(file), sink_.batch(), span.session, span.first_id, times, wanted);
}

} // namespace cli
