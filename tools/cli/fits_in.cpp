// FITS images and cubes as frames: every BITPIX with BZERO and BSCALE, tiles as compressed by fpack.
#include <cstring>
#include <limits>

#include "failure.hpp"
#include "fits.hpp"
#include "frames_in.hpp"
#include "input.hpp"

namespace cli {

namespace {

class FitsFrames : public FrameFile {
  public:
    explicit FitsFrames(const std::string &path) : FrameFile(path) {
        const size_t size = check_is_fits();
        int status = 0;
        fitsfile *file = nullptr;
        fits_open_diskfile(&file, plain_name(path).c_str(), READONLY, &status);
        file_.reset(file);
        check(status);
        const int axes = find_image();
        std::vector<LONGLONG> lengths(static_cast<size_t>(axes));
        fits_get_img_sizell(file, axes, lengths.data(), &status);
        LONGLONG end = 0;
        fits_get_hduaddrll(file, nullptr, nullptr, &end, &status);
        check(status);
        set_axes({lengths.rbegin(), lengths.rend()}); // NAXIS1 is the columns
        if (static_cast<size_t>(end) > size)
            malformed(path, "holds " + std::to_string(size) + " bytes, up to the end of its image it takes " +
                                std::to_string(end));
    }

  private:
    void check(int status) const {
        if (status != 0)
            malformed(path_, "cannot be read as FITS: " + fits_reason(status));
    }

    // CFITSIO itself would also look for other names and other kinds of files.
    size_t check_is_fits() const {
        InputFile file(path_);
        if (file.size() == 0)
            malformed(path_, "is empty");
        char start[9];
        if (!file.read(start, sizeof start) || std::memcmp(start, "SIMPLE  =", sizeof start) != 0)
            malformed(path_, "is not a FITS file");
        return file.size();
    }

    // Moves to the first image that holds pixels; returns how many axes it has.
    int find_image() {
        for (int unit = 1;; unit++) {
            int status = 0, kind = 0, axes = 0;
            if (fits_movabs_hdu(file_.get(), unit, &kind, &status) == END_OF_FILE)
                malformed(path_, "holds no image");
            if (kind == IMAGE_HDU)
                fits_get_img_dim(file_.get(), &axes, &status);
            check(status);
            if (axes > 0)
                return axes;
        }
    }

    void next(double *image) override {
        const LONGLONG pixels = static_cast<LONGLONG>(rows()) * static_cast<LONGLONG>(cols());
        double blank = std::numeric_limits<double>::quiet_NaN();
        int status = 0, any = 0;
        fits_read_img(file_.get(), TDOUBLE, first_, pixels, &blank, image, &any, &status);
        check(status);
        first_ += pixels;
    }

    Fits file_;
    LONGLONG first_ = 1; // pixel of the next frame
};

} // namespace

std::unique_ptr<FrameFile> open_fits(const std::string &path) {
    return std::make_unique<FitsFrames>(path);
}

} // namespace cli
