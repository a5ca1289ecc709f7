// Finds frames that are not at their places in a file, because bytes before them were lost or added.
#pragma once
#include <deque>

#include "downlink/frame_source.hpp"

namespace cli {

class Realigner {
  public:
    // The library's function for misfits, of a Realigner as user data.
    static int32_t call(const toliman_frame *frame, const toliman_track_outcome *outcome, toliman_frame *other,
                        void *realigner) noexcept;

    // The frames that are pushed next, with the sources and places from which they come.
    void begin() noexcept;
    void expect(const toliman_frame &frame, const std::shared_ptr<FrameSource> &source, int64_t offset);
    // How far from its place a frame was found, bytes; 0: there, or not found.
    int64_t shift_of(const toliman_frame &frame) const;
    // After a push: a good frame is the reference of the frames that follow, a known one if there is none yet.
    void settle(const toliman_frame &frame, bool is_good, bool is_known);

  private:
    struct Origin {
        std::shared_ptr<FrameSource> source;
        int64_t offset, shift;
    };
    int32_t find(const toliman_frame &frame, toliman_frame &other);

    std::map<const void *, Origin> origins_; // by the pixels of the frames
    std::deque<std::vector<uint8_t>> found_; // pixels of the frames that are pushed
    toliman_frame reference_ = toliman::sized<toliman_frame>();
    std::vector<uint8_t> pixels_; // of the reference; empty: there is none yet
};

} // namespace cli
