// Frames of a pair of files or of a batch as one file of frames, for `encode` and `calibrate`. A first reading finds
// the valid frames, their number and times; the second one delivers them. What the first one complains about is in
// notes().
#include <set>

#include "frames/frames_in.hpp"

namespace cli {

namespace {

class MissionFrames final : public FrameFile {
  public:
    MissionFrames(const std::string &path, const toliman_ingest_options &options) : FrameFile(path), options_(options) {
        if (is_batch(path))
            probe_batch(path);
        std::set<std::string> regions;
        size_t rows = 0, cols = 0;
        for (open(); next();) {
            if (event_.event != TOLIMAN_INGEST_EVENT_FRAME) {
                notes_.push_back(std::string(event_.file) + ":" + std::to_string(event_.line) + ": " + event_.text);
                continue;
            }
            if (times_.empty()) {
                rows = static_cast<size_t>(frame_.rows);
                cols = static_cast<size_t>(frame_.cols);
                pixel_ = frame_.pixel;
                id_ = frame_.frame_id;
            }
            windows_.push_back({frame_.window_row, frame_.window_col});
            regions.insert(frame_.roi);
            times_.push_back(frame_.camera_ns);
            has_sums_ |= frame_.spread != nullptr;
            spreads_.push_back(frame_.spread != nullptr ? *frame_.spread : toliman::sized<toliman_spread>());
            check_frame(rows, cols, regions);
        }
        if (times_.empty())
            malformed(path, "contains no frames" +
                                (options_.roi == nullptr ? "" : std::string(" of the region ") + options_.roi));
        set_axes({times_.size(), rows, cols});
        open();
    }

    int32_t pixel() const noexcept override { return pixel_; }
    size_t frame_size() const noexcept override { return rows() * cols() * (pixel() == TOLIMAN_PIXEL_U32 ? 4 : 2); }
    std::vector<int64_t> camera_ns() override { return times_; }
    std::vector<toliman_spread> spreads() override { return has_sums_ ? spreads_ : std::vector<toliman_spread>(); }
    std::optional<int64_t> first_id() override { return id_; }
    double exposure_s() override { return options_.exposure_s; }
    std::optional<FrameWindow> window(size_t frame) override { // 0, 0: unknown
        return windows_.at(frame) != FrameWindow() ? std::optional(windows_.at(frame)) : std::nullopt;
    }
    const std::vector<std::string> &notes() const noexcept override { return notes_; }

  private:
    void open() {
        toliman_ingest *reader = nullptr;
        check(toliman_ingest_create(path_.c_str(), &options_, &reader));
        reader_.reset(reader);
        delivered_ = 0;
    }

    // The files are not ours: an error of theirs is one of the input.
    void check(toliman_status status) const {
        if (status == TOLIMAN_E_FORMAT || status == TOLIMAN_E_NOT_FOUND || status == TOLIMAN_E_UNSUPPORTED)
            throw Failure(kExitInput, toliman_last_error());
        toliman::check(status);
    }

    bool next() {
        frame_ = toliman::sized<toliman_frame>();
        event_ = toliman::sized<toliman_ingest_event>();
        check(toliman_ingest_next(reader_.get(), &frame_, &event_));
        return event_.event != TOLIMAN_INGEST_EVENT_NOTHING;
    }

    void check_frame(size_t rows, size_t cols, const std::set<std::string> &regions) const {
        const std::string place = std::string(event_.file) + ":" + std::to_string(event_.line);
        if (regions.size() > 1)
            throw Failure(kExitUsage, place + ": frames of the regions " + *regions.begin() + ", " + *regions.rbegin() +
                                          ": --roi LABEL takes those of one");
        if (static_cast<size_t>(frame_.rows) != rows || static_cast<size_t>(frame_.cols) != cols)
            malformed(place, "a frame of " + shape_text(frame_.rows, frame_.cols) + " after frames of " +
                                 shape_text(rows, cols));
    }

    void load(size_t frame, void *pixels) override {
        for (; delivered_ <= frame; delivered_ += event_.event == TOLIMAN_INGEST_EVENT_FRAME)
            if (!next() || (frame_.pixels != nullptr && frame_.pixel != pixel_))
                malformed(path_, "has changed while it was read");
        std::memcpy(pixels, frame_.pixels, frame_size());
    }

    toliman_ingest_options options_;
    toliman::pair_reader reader_;
    toliman_frame frame_;
    toliman_ingest_event event_;
    std::vector<int64_t> times_;
    std::vector<toliman_spread> spreads_;
    bool has_sums_ = false;
    std::vector<std::string> notes_;
    std::vector<FrameWindow> windows_;
    int32_t pixel_ = 0;
    int64_t id_ = 0;
    size_t delivered_ = 0; // frames of the second reading
};

} // namespace

std::unique_ptr<FrameFile> open_mission(const std::string &path, const toliman_ingest_options &options) {
    return std::make_unique<MissionFrames>(path, options);
}

} // namespace cli
