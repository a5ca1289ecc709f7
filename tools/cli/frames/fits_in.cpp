// Reads FITS images and cubes as frames: any BITPIX with BZERO and BSCALE, also tile-compressed by fpack, or the whole
// file by gzip. The HDU with the name CORE is used, wherever it is in the file, otherwise the first one with pixels.
// Keywords are looked up in its header, then in the primary header. Those of the mission's image service, which are not
// of the FITS standard, are SEQNUM, CAMTIME in ns, EXPOSURE in us, and the place of the core on the detector. The file
// is opened by fits_open_diskfile, because CFITSIO treats file names as expressions (filters, URLs, ~), and its first
// bytes are checked before. Undefined pixels are NaN.
#include <limits>

#include "common/content.hpp"
#include "frames/fits.hpp"
#include "frames/frames_in.hpp"

namespace cli {

namespace {

class FitsFrames : public FrameFile {
  public:
    FitsFrames(const std::string &path, const std::string &unit) : FrameFile(path) {
        const size_t size = check_is_fits();
        int status = 0;
        fitsfile *file = nullptr;
        cfitsio().open_diskfile(&file, plain_name(path).c_str(), READONLY, &status);
        file_.reset(file);
        check(status);
        find_image(unit);
        const std::vector<LONGLONG> lengths = lengths_here();
        LONGLONG end = 0;
        cfitsio().get_hduaddrll(file, nullptr, nullptr, &end, &status);
        check(status);
        set_axes({lengths.rbegin(), lengths.rend()}); // NAXIS1 is the columns
        if (static_cast<size_t>(end) > size)
            malformed(path, "is truncated: it has " + std::to_string(size) + " bytes, its image ends at byte " +
                                std::to_string(end));
        cfitsio().get_hdu_num(file, &unit_);
        if (unit.empty())
            note_others(lengths);
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
        if (cfitsio().movnam_hdu(file_.get(), BINARY_TBL, table, 0, &status) == 0 &&
            cfitsio().get_colnum(file_.get(), CASEINSEN, column, &number, &status) == 0) {
            cfitsio().get_num_rowsll(file_.get(), &rows, &status);
            if (static_cast<size_t>(rows) != count())
                malformed(path_, "table FRAMES has " + std::to_string(rows) + " rows: must have " +
                                     std::to_string(count()) + ", one per frame");
            days.resize(count());
            double blank = std::numeric_limits<double>::quiet_NaN();
            cfitsio().read_col(file_.get(), TDOUBLE, number, 1, 1, rows, &blank, days.data(), nullptr, &status);
            check(status);
        }
        move_to(unit_);
        return days;
    }

    std::vector<int64_t> camera_ns() override {
        const std::optional<int64_t> start = whole_number("CAMTIME");
        if (!start || count() != 1)
            return {};
        return {*start + std::llround(exposure_s() * 5e8)};
    }

    std::optional<int64_t> first_id() override {
        const std::optional<int64_t> own = whole_number("FRAME1");
        return own ? own : whole_number("SEQNUM");
    }

    double exposure_s() override {
        constexpr double kLongest = 1e9;
        const std::optional<std::string> text = value_of("CAMTIME") ? value_of("EXPOSURE") : std::nullopt;
        double us = 0;
        if (text && !(number_of(*text, us) && us >= 0 && us <= kLongest * 1e6))
            malformed(path_, "EXPOSURE = " + *text + ": must be from 0 to 1e15 us");
        return us / 1e6;
    }

    std::optional<FrameWindow> window(size_t) override {
        if (!value_of("CENTR_X") && !value_of("CENTR_Y"))
            return std::nullopt;
        constexpr int64_t kHalfCore = 64; // px from its first pixel to CENTR, less at the edge of the raw image
        const auto first = [this](const char *offset, const char *centre) {
            const std::optional<int64_t> middle = whole_number(centre);
            return middle ? whole_number(offset).value_or(0) + std::max<int64_t>(*middle - kHalfCore, 0) : 0;
        };
        return FrameWindow{first("YOFF", "CENTR_Y"), first("XOFF", "CENTR_X")};
    }

    const std::vector<std::string> &notes() const noexcept override { return notes_; }

  private:
    // The value of a keyword that must be a whole number, also as text.
    std::optional<int64_t> whole_number(const char *key) {
        std::optional<std::string> text = value_of(key);
        int64_t value = 0;
        if (text && text->size() > 2 && text->front() == '\'')
            text = text->substr(1, text->find_last_not_of(" '"));
        if (text && !is_whole_number(*text, value))
            malformed(path_, key + (" = " + *text) + ": must be a whole number from -2^62 to 2^62");
        return text ? std::optional<int64_t>(value) : std::nullopt;
    }

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
        const bool is_long = file.read(start, sizeof start);
        const bool is_packed = is_long && ends_with(path_, ".gz") && std::memcmp(start, "\x1f\x8b", 2) == 0;
        if (!is_packed && (!is_long || std::memcmp(start, "SIMPLE  =", sizeof start) != 0))
            malformed(path_, "is not a FITS file" + kind_of(path_));
        return is_packed ? SIZE_MAX : file.size(); // CFITSIO unpacks it into memory
    }

    void move_to(int unit) {
        int status = 0;
        cfitsio().movabs_hdu(file_.get(), unit, nullptr, &status);
        check(status);
    }

    std::optional<std::string> value_in(int unit, const std::string &key) {
        char value[FLEN_VALUE] = "";
        int status = 0;
        move_to(unit);
        cfitsio().read_keyword(file_.get(), key.c_str(), value, nullptr, &status);
        move_to(unit_);
        if (status == KEY_NO_EXIST)
            return std::nullopt;
        check(status);
        const bool is_undefined = value[std::strspn(value, "' ")] == '\0'; // no value, or a string without characters
        return is_undefined ? std::nullopt : std::optional<std::string>(value);
    }

    // Axes of the image in the current unit, NAXIS1 first; empty if it has none.
    std::vector<LONGLONG> lengths_here() {
        int status = 0, kind = 0, axes = 0;
        cfitsio().get_hdu_type(file_.get(), &kind, &status);
        if (kind == IMAGE_HDU)
            cfitsio().get_img_dim(file_.get(), &axes, &status);
        std::vector<LONGLONG> lengths(static_cast<size_t>(axes));
        if (axes > 0)
            cfitsio().get_img_sizell(file_.get(), axes, lengths.data(), &status);
        check(status);
        return lengths;
    }

    // Moves to the unit with this name or number.
    bool move_to_unit(const std::string &unit) {
        int status = 0;
        int64_t number = 0;
        if (is_whole_number(unit, number)) // HDU 0 is the primary one, as in the standard's tools
            cfitsio().movabs_hdu(file_.get(), static_cast<int>(std::clamp<int64_t>(number, -1, 1 << 20)) + 1, nullptr,
                                 &status);
        else
            cfitsio().movnam_hdu(file_.get(), ANY_HDU, std::string(unit).data(), 0, &status);
        return status == 0;
    }

    // Moves to the unit with this number, 1 for the primary one, and returns CFITSIO's status.
    int status_of_unit(int unit) {
        int status = 0;
        return cfitsio().movabs_hdu(file_.get(), unit, nullptr, &status);
    }

    // Moves to the image.
    void find_image(const std::string &wanted) {
        if (!wanted.empty() && (!move_to_unit(wanted) || lengths_here().empty()))
            malformed(path_, "--hdu " + wanted + ": there is no such image");
        if (!wanted.empty() || (move_to_unit("CORE") && !lengths_here().empty()))
            return;
        for (int unit = 1;; unit++) {
            const int status = status_of_unit(unit);
            if (status == END_OF_FILE)
                malformed(path_, "contains no image");
            check(status);
            if (!lengths_here().empty())
                return;
        }
    }

    // Exposures in units of their own, as of the Hubble Space Telescope, are of one name and size. A damaged unit ends
    // the search: it does not concern the frame that is read.
    void note_others(const std::vector<LONGLONG> &lengths) {
        const auto name_of = [this](int unit) { return value_in(unit, "EXTNAME"); };
        const std::optional<std::string> name = name_of(unit_);
        std::string others;
        for (int unit = unit_ + 1; status_of_unit(unit) == 0; unit++)
            if (lengths_here() == lengths && name_of(unit) == name)
                others += (others.empty() ? "" : ", ") + std::to_string(unit - 1);
        move_to(unit_);
        if (!others.empty())
            notes_.push_back("HDU " + std::to_string(unit_ - 1) +
                             " is read alone: images of its name and size in HDU " + others + " are not (--hdu)");
    }

    void load(size_t frame, void *pixels) override {
        const auto count = static_cast<LONGLONG>(rows()) * static_cast<LONGLONG>(cols());
        double blank = std::numeric_limits<double>::quiet_NaN();
        int status = 0, any = 0;
        cfitsio().read_img(file_.get(), TDOUBLE, 1 + static_cast<LONGLONG>(frame) * count, count, &blank, pixels, &any,
                           &status);
        check(status);
    }

    Fits file_;
    int unit_ = 0; // number of the image's HDU
    std::vector<std::string> notes_;
};

} // namespace

std::unique_ptr<FrameFile> open_fits(const std::string &path, const std::string &unit) {
    return std::make_unique<FitsFrames>(path, unit);
}

} // namespace cli
