// Reads FITS images and cubes as frames: any BITPIX with BZERO and BSCALE, also tile-compressed by fpack. The first HDU
// with pixels is used. Keywords are looked up in its header, then in the primary header. The file is opened by
// fits_open_diskfile, because CFITSIO treats file names as expressions (filters, URLs, ~), and its first bytes are
// checked before. Undefined pixels are NaN.
#include <cstring>
#include <limits>

#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/input.hpp"
#include "frames/fits.hpp"
#include "frames/frames_in.hpp"

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
            malformed(path, "is truncated: it has " + std::to_string(size) + " bytes, its image ends at byte " +
                                std::to_string(end));
        fits_get_hdu_num(file, &unit_);
    }

    std::optional<std::string> value_of(const std::string &key) override {
        std::optional<std::string> value = value_in(unit_, key);
        return value || unit_ == 1 ? value : value_in(1, key);
    }

    std::vector<double> days() override {
        char table[] = "FRAMES", column[] = "time_days";
        int status = 0, number = 0;
        LONGLONG rows = 0;
        std::vector<double> days;
        if (fits_movnam_hdu(file_.get(), BINARY_TBL, table, 0, &status) == 0 &&
            fits_get_colnum(file_.get(), CASEINSEN, column, &number, &status) == 0) {
            fits_get_num_rowsll(file_.get(), &rows, &status);
            if (static_cast<size_t>(rows) != count())
                malformed(path_, "table FRAMES has " + std::to_string(rows) + " rows: must have " +
                                     std::to_string(count()) + ", one per frame");
            days.resize(count());
            double blank = std::numeric_limits<double>::quiet_NaN();
            fits_read_col(file_.get(), TDOUBLE, number, 1, 1, rows, &blank, days.data(), nullptr, &status);
            check(status);
        }
        move_to(unit_);
        return days;
    }

  private:
    void check(int status) const {
        if (status != 0)
            malformed(path_, "cannot be read as FITS: " + fits_reason(status));
    }

    // CFITSIO itself would also try other names and other types of files.
    size_t check_is_fits() const {
        InputFile file(path_);
        if (file.size() == 0)
            malformed(path_, "is empty");
        char start[9];
        if (!file.read(start, sizeof start) || std::memcmp(start, "SIMPLE  =", sizeof start) != 0)
            malformed(path_, "is not a FITS file" + kind_of(path_));
        return file.size();
    }

    void move_to(int unit) {
        int status = 0;
        fits_movabs_hdu(file_.get(), unit, nullptr, &status);
        check(status);
    }

    std::optional<std::string> value_in(int unit, const std::string &key) {
        char value[FLEN_VALUE] = "";
        int status = 0;
        move_to(unit);
        fits_read_keyword(file_.get(), key.c_str(), value, nullptr, &status);
        move_to(unit_);
        if (status == KEY_NO_EXIST)
            return std::nullopt;
        check(status);
        if (value[0] == '\0') // a keyword without value is undefined
            return std::nullopt;
        return value;
    }

    // Moves to the first image with pixels and returns its number of axes.
    int find_image() {
        for (int unit = 1;; unit++) {
            int status = 0, kind = 0, axes = 0;
            if (fits_movabs_hdu(file_.get(), unit, &kind, &status) == END_OF_FILE)
                malformed(path_, "contains no image");
            if (kind == IMAGE_HDU)
                fits_get_img_dim(file_.get(), &axes, &status);
            check(status);
            if (axes > 0)
                return axes;
        }
    }

    void load(size_t frame, void *pixels) override {
        const auto count = static_cast<LONGLONG>(rows()) * static_cast<LONGLONG>(cols());
        double blank = std::numeric_limits<double>::quiet_NaN();
        int status = 0, any = 0;
        fits_read_img(file_.get(), TDOUBLE, 1 + static_cast<LONGLONG>(frame) * count, count, &blank, pixels, &any,
                      &status);
        check(status);
    }

    Fits file_;
    int unit_ = 0; // number of the image's HDU
};

} // namespace

std::unique_ptr<FrameFile> open_fits(const std::string &path) {
    return std::make_unique<FitsFrames>(path);
}

} // namespace cli
