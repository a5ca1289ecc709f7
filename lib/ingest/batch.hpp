// Reader of a batch of frames, a netCDF file of the image service.
#pragma once
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "backend/netcdf.hpp"
#include "base/buffer.hpp"
#include "ingest/reader.hpp"

namespace toliman::ingest {

bool is_batch(const std::string &path) noexcept; // by its suffix, .nc

class Batch final : public Reader {
  public:
    // Reads all but the pixels. Status as netcdf::File; Status::format for other contents than those of formats.md.
    Batch(const std::string &path, const ReaderOptions &options);

    Event next() override;
    ReaderCounts counts() const noexcept override;
    size_t pixel_bytes() const noexcept override { return sizeof(uint16_t); }
    const std::string &side_path() const noexcept override { return path_; }
    const std::string &pixel_path() const noexcept override { return path_; }

  private:
    struct Slot {
        Buffer<uint16_t> pixels;
        std::string text;
    };
    void find_kind();
    void read_numbers();
    void read_attributes();
    void count_restarts();
    template <class Number> std::vector<Number> column(const char *name) const;
    void read_pixels(size_t frame);
    Event frame_event(Slot &slot);
    Event warning(Slot &slot);

    std::string path_;
    std::unique_ptr<netcdf::File> file_; // closed after the last frame
    uint64_t bytes_;
    const char *reference_, *differences_; // names of the variables
    bool is_successive_;                   // differences from frame to frame, not from the first one
    size_t rows_, cols_;
    int32_t most_; // largest possible pixel
    std::set<std::string> names_;
    std::vector<SideLine> lines_;
    std::vector<int32_t> pixels_, change_; // the last frame that was read; its difference
    size_t next_ = 0, read_ = 0;           // frames that were reported; that were read
    bool is_warned_ = false;               // of the next frame
    std::vector<Slot> slots_;
    size_t slot_ = 0;
    ReaderCounts counts_;
};

} // namespace toliman::ingest
