// The mission's pair of files, <session>_frames.bin and <session>_meta.jsonl, also while they grow.
#pragma once
#include <string>
#include <vector>

#include "common/input.hpp"
#include "downlink/arrival.hpp"
#include "downlink/side_file.hpp"

namespace cli {

struct PairFormat {
    bool wide;         // u32le rather than u16le
    size_t rows, cols; // of the frames that the tracker takes
};

bool is_pair(const std::string &path); // one of the two files
std::string side_of(const std::string &path);
std::string binary_of(const std::string &path);

class Pair {
  public:
    // path: either of the two files.
    Pair(const std::string &path, const PairFormat &format)
        : side_(side_of(path)), binary_(binary_of(path)), format_(format) {}

    // Gives the frames that were not there before.
    void read(Receiver &receiver, bool growing);
    // Tells of those that never came, and of bytes that belong to none. Of a pair that grows, only where all its frames
    // were given and the last two looks, and this one, find the same files: the others may go on.
    void end(Receiver &receiver);

  private:
    struct Place {
        size_t offset, size;
    };
    size_t usual_bytes() const noexcept;
    size_t bytes(const SideLine &line) const noexcept;
    std::string other_dtype() const;
    bool is_unchanged() const;
    void place(size_t size);
    void give(Receiver &receiver);
    size_t good_before(size_t line) const noexcept;
    bool stands(size_t before, size_t line) const noexcept;
    void remark_drift(Receiver &receiver, size_t line);
    std::string jump_at(size_t line, double usual) const;
    double usual_gap() const;
    std::string where(size_t line) const { return side_ + ":" + std::to_string(line + 1); }

    std::string side_, binary_;
    PairFormat format_;
    FileStamp side_stamp_, binary_stamp_;  // when last looked at
    bool doubtful_ = false;                // it may be under way: whether it is what it seems is seen at the next look
    bool growing_ = false, rests_ = false; // rests_: the last look found nothing new
    bool drift_told_ = false;
    std::vector<SideLine> lines_;
    std::vector<Place> places_; // of the first lines; the others have none
    size_t used_ = 0;           // bytes, up to the last place
    size_t given_ = 0;          // lines
};

} // namespace cli
