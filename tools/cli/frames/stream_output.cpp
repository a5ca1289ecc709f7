#include "frames/stream_output.hpp"

#include "frames/frames_out.hpp"

namespace cli {

namespace {

class PairStream : public StreamOutput {
  public:
    using StreamOutput::StreamOutput;

    void begin_session() override {
        frames_ = open("_frames.bin");
        lines_ = open("_meta.jsonl");
    }

    void add(const Exposure &exposure, const uint16_t *counts) override {
        frames_->write(counts, layout_.pixels() * sizeof *counts);
        lines_->write("{" +
                      side_members({exposure.frame_id, exposure.stamp_ns, exposure.host_s, exposure.dropped},
                                   layout_.roi, layout_.rows, layout_.cols, session_, "u16le") +
                      "}\n");
    }

    // The side file last: it implies that the frames are complete.
    void commit() override {
        if (!lines_)
            return;
        lines_->finish();
        frames_->commit();
        lines_->commit();
        layout_.folder.keep();
        frames_.reset();
        lines_.reset();
    }

  private:
    std::unique_ptr<OutputFile> open(const char *end) const {
        return std::make_unique<OutputFile>(free_path(layout_.folder.file(session_ + end)));
    }

    std::unique_ptr<OutputFile> frames_, lines_;
};

} // namespace

std::string StreamLayout::session_of(const Exposure &exposure) const {
    return exposure.session == 0 ? session : session + "-" + std::to_string(exposure.session + 1);
}

void StreamOutput::write(const Exposure &exposure, const uint16_t *counts) {
    const std::string session = layout_.session_of(exposure);
    if (session != session_) {
        commit();
        session_ = session;
        begin_session();
    }
    add(exposure, counts);
}

std::unique_ptr<StreamOutput> pair_stream(const StreamLayout &layout) {
    return std::make_unique<PairStream>(layout);
}

TruthTable::TruthTable(const StreamLayout &layout)
    : layout_(layout), file_(free_path(layout.folder.file(layout.session + "_truth.csv"))) {
    file_.write(std::string(
        "index,session,restarts,frame_id,timestamp_ns,host_time,dropped,x_px,y_px,separation_px,cosmic_rays\n"));
}

void TruthTable::write(const Exposure &exposure, double separation_px, size_t hits) {
    file_.write(formatted("%lld,%s,%lld,%lld,%lld,%.9f,%d,%.9f,%.9f,%.12g,%zu\n",
                          static_cast<long long>(exposure.index), layout_.session_of(exposure).c_str(),
                          static_cast<long long>(exposure.restarts), static_cast<long long>(exposure.frame_id),
                          static_cast<long long>(exposure.stamp_ns), exposure.host_s, exposure.is_dropped ? 1 : 0,
                          exposure.x_px, exposure.y_px, separation_px, hits));
}

} // namespace cli
