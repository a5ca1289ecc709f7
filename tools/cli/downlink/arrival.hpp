// Frames as they arrive, and who takes them.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace cli {

// What a side file says of a frame.
struct FrameFacts {
    std::string session, roi;
    int64_t id = 0, camera_ns = 0, dropped = 0;
    size_t rows = 0, cols = 0;
};

struct Arrival {
    std::string where; // "x_meta.jsonl:7", for messages
    FrameFacts facts;
    int32_t pixel = 0; // TOLIMAN_PIXEL_...
    std::vector<unsigned char> pixels;
};

// What is wrong with an input beside frames that the tracker itself rejects.
enum class Remark { unreadable, extra_bytes, clock_jump };
constexpr size_t kRemarks = 3;

class Receiver {
  public:
    Receiver() = default;
    virtual ~Receiver() = default;
    Receiver(const Receiver &) = delete;
    Receiver &operator=(const Receiver &) = delete;
    // One to fill, for take().
    virtual Arrival &next() = 0;
    virtual void take() = 0;
    // A frame that cannot be read at all. facts: NULL where nothing is known of it; of a bad line session, region and
    // frame id alone.
    virtual void reject(const std::string &where, const FrameFacts *facts, const char *reason,
                        const std::string &why) = 0;
    virtual void remark(Remark kind, const std::string &where, const std::string &text) = 0;
    // What is no damage but should be known of an input. remark: as formats.md calls it.
    virtual void tell(const char *remark, const std::string &where, const std::string &text, bool warning) = 0;
    // Whether a frame is asked for; one that is not needs no reading, is counted, and nothing is said of it.
    virtual bool wants(const FrameFacts &facts) = 0;
    // To be called while nothing comes.
    virtual void wait() = 0;
};

} // namespace cli
