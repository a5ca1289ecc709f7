// Files of frames: finds them by their names, and reads frames one by one: .npy, FITS, headerless or the mission's.
#pragma once
#include <toliman/image.h>
#include <toliman/spread.h>

#include "common/common.hpp"
#include "common/interface.hpp"

namespace cli {

using FrameWindow = std::array<int64_t, 2>; // row and column on the detector of a frame's first pixel

// Frames of a file or of standard input, one by one.
class FrameFile : public Interface {
  public:
    const std::vector<size_t> &axes() const noexcept { return axes_; } // as in the file: 2 or 3, columns last
    size_t count() const noexcept { return axes_.size() == 3 ? axes_[0] : 1; }
    size_t rows() const noexcept { return axes_[axes_.size() - 2]; }
    size_t cols() const noexcept { return axes_.back(); }
    // False for headerless frames on standard input: count() is then an upper bound, and more() waits for the next
    // frame.
    virtual bool counted() const noexcept { return true; }
    virtual bool more() { return next_ < count(); }
    // TOLIMAN_PIXEL_... of the frames that read() delivers, and the bytes of a frame.
    virtual int32_t pixel() const noexcept { return TOLIMAN_PIXEL_F64; }
    virtual size_t frame_size() const noexcept { return rows() * cols() * sizeof(double); }
    // Reads the next frame unchecked; a pixel without value is NaN. `pixels` is aligned to 8 bytes.
    void read(void *pixels) { load(next_++, pixels); }
    // Reads the next frame as double. Returns the number of the first pixel that is not a finite number.
    std::optional<size_t> read_values(double *image);
    void read_finite(double *image);  // throws Failure for such a pixel
    void skip() noexcept { next_++; } // not on standard input

    // The value of a FITS keyword as it is written, strings in quotes without trailing blanks: from the header of the
    // image, otherwise from the primary header.
    virtual std::optional<std::string> value_of(const std::string &) { return std::nullopt; }
    // The column time_days of the table FRAMES, one row per frame; empty if there is no such table.
    virtual std::vector<double> days() { return {}; }
    // Times by the camera's clock, ns: of the middle of each exposure if its length is known, otherwise as stamped.
    // Empty if the file has none.
    virtual std::vector<int64_t> camera_ns() { return {}; }
    // Id of the first frame of the file; empty if the file has none.
    virtual std::optional<int64_t> first_id() { return std::nullopt; }
    // Length of each exposure by the file's own keywords, in s; 0: unknown.
    virtual double exposure_s() { return 0; }
    // Row and column on the detector of the first pixel of a frame; empty if the file does not tell.
    virtual std::optional<FrameWindow> window(size_t) { return std::nullopt; }
    const std::string &path() const noexcept { return path_; }
    // Of frames that are sums of frames, one for each; empty if they are single frames.
    virtual std::vector<toliman_spread> spreads() { return {}; }
    // What was found damaged or suspicious, for warnings.
    virtual const std::vector<std::string> &notes() const noexcept {
        static const std::vector<std::string> kNone;
        return kNone;
    }

  protected:
    explicit FrameFile(const std::string &path) : path_(path) {}
    void set_axes(const std::vector<size_t> &axes); // throws Failure unless they are the axes of frames
    std::string path_;

  private:
    virtual void load(size_t frame, void *pixels) = 0;
    std::vector<size_t> axes_;
    std::vector<unsigned char> raw_; // of read_values
    size_t next_ = 0;
};

// "row 3, column 4: must be a finite number ...", of a pixel by its number.
std::string blank_text(size_t pixel, size_t cols);

// Days, as in the table FRAMES and in scenes, to nanoseconds: whole days are exact, the fraction is rounded. Empty
// beyond 100,000 days.
std::optional<int64_t> ns_of_days(double days);

bool is_fits(const std::string &path);                         // by its suffix, .fits, .fits.fz or .fits.gz
bool is_whole_number(const std::string &text, int64_t &value); // from -2^62 to 2^62

// Pixel types of headerless files: u16le, u32le, i16le, f32le and the same with be (big-endian).
std::vector<std::string> dtypes();

// Opens a file by its suffix; - is standard input, .npy unless dtype or shape are given. dtype, one of dtypes(), and
// shape are for headerless files only; unit, the name or number of the HDU, for FITS files only.
std::unique_ptr<FrameFile> open_frames(const std::string &path, const std::string &dtype = "", size_t rows = 0,
                                       size_t cols = 0, const std::string &unit = "");
std::unique_ptr<FrameFile> open_fits(const std::string &path, const std::string &unit);

// TOLIMAN_PIXEL_... of --dtype, 0 for "" and for a batch; throws Failure for a type that a pair cannot have.
int32_t pixel_of_pair(const std::string &path, const std::string &dtype);
// A pair of files or a batch. options.roi must outlive the frames.
std::unique_ptr<FrameFile> open_mission(const std::string &path, const toliman_ingest_options &options);

bool is_pair(const std::string &path);       // one of the two files, by its suffix
bool is_batch(const std::string &path);      // .nc
bool is_dated_file(const std::string &path); // .npy or FITS

// The path of the other file of a pair; of its side file.
std::string other_file(const std::string &path);
std::string side_of(const std::string &path);
// Throws Failure for the file of a pair that is missing.
void check_complete(const std::string &side);

// Side files of the pairs of a folder, in the order of their names; either file of a pair may be missing. Without
// pairs, its batches, and without these, its FITS files, shorter names first, so that numbers and times of the camera
// in them increase: the same frames may be there in several forms.
std::vector<std::string> files_of(const std::string &folder);
// The files of an input: those of a folder, or itself.
std::vector<std::string> files_in(const std::string &input);
// roi_label of the first line of a side file that has one; "" for none.
std::string region_of(const std::string &side);
// Whether inputs may have other files than .npy and FITS ones.
bool has_stamps(const std::vector<std::string> &inputs);

// Throws Failure, which lists them, if the pairs among files and folders have several regions of the detector, by the
// first roi_label of each: frames of two regions must not share a periodogram or a calibration.
void check_one_region(const std::vector<std::string> &inputs);

// Throws Failure if netCDF crashes on the file, as HDF5 1.10 does where the checksum of a table of names is wrong.
// Errors that netCDF reports are left to the reader.
void probe_batch(const std::string &path);

} // namespace cli
