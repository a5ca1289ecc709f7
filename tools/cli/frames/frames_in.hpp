// Frames of a file or of standard input, one after the other, as double: .npy, FITS or headerless.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cli {

class FrameFile {
  public:
    virtual ~FrameFile() = default;
    FrameFile(const FrameFile &) = delete;
    FrameFile &operator=(const FrameFile &) = delete;
    const std::vector<size_t> &axes() const noexcept { return axes_; } // as in the file: 2 or 3, columns last
    size_t count() const noexcept { return axes_.size() == 3 ? axes_[0] : 1; }
    size_t rows() const noexcept { return axes_[axes_.size() - 2]; }
    size_t cols() const noexcept { return axes_.back(); }
    // False for headerless frames on standard input: count() is then a bound, and more() waits for the next one.
    virtual bool counted() const noexcept { return true; }
    virtual bool more() { return read_ < count(); }
    // The next frame, every pixel a finite number.
    void read(double *image);
    // The next frame as it is; a pixel without value is NaN.
    void read_any(double *image);
    // Passes over the next frame.
    void skip();

    // What the header says, as it is written there: strings in quotes, trailing blanks cut. Of FITS that of the image
    // or else of the file.
    virtual std::optional<std::string> value_of(const std::string &) { return std::nullopt; }
    // The column time_days of the table FRAMES, of a row a frame; empty where there is none.
    virtual std::vector<double> days() { return {}; }
    const std::string &path() const noexcept { return path_; }

  protected:
    explicit FrameFile(const std::string &path) : path_(path) {}
    void set_axes(const std::vector<size_t> &axes); // a Failure unless they are those of frames
    std::string path_;

  private:
    virtual void next(double *image) = 0; // a pixel without value is NaN
    virtual void pass() = 0;
    std::vector<size_t> axes_;
    size_t read_ = 0;
};

bool is_fits(const std::string &path); // by its suffix, .fits or .fits.fz

// Pixels of headerless files: u16le, u32le, i16le and f32le, and the same ending in be.
const std::vector<std::string> &dtypes();

// The reader that the file's suffix asks for; - is standard input, .npy unless dtype or shape are given. dtype, one of
// dtypes(), and shape are for headerless files only.
std::unique_ptr<FrameFile> open_frames(const std::string &path, const std::string &dtype = "", size_t rows = 0,
                                       size_t cols = 0);
std::unique_ptr<FrameFile> open_fits(const std::string &path);

} // namespace cli
