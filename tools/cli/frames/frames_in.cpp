// Format: .npy or headerless pixels, read one frame at a time in their own type, which the library converts. The sizes
// are checked before any allocation: sides and number of frames are bounded, so no product overflows, and the file must
// have exactly the bytes of its shape. Only headerless standard input has an unknown number of frames.
#include "frames/frames_in.hpp"

#include <charconv>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/content.hpp"
#include "common/npy.hpp"

namespace cli {

namespace {

constexpr size_t kMostFrames = size_t{1} << 24, kLargestSide = size_t{1} << 14;

InputFile open_input(const std::string &path) {
    return path == "-" ? InputFile::standard_input() : InputFile(path);
}

// Types of .npy, by NumPy's names, and of headerless files. The library has no 64-bit integers: they are converted to
// double.
struct PixelType {
    const char *name;
    size_t width; // bytes
    int32_t pixel;
};
constexpr PixelType kPixelTypes[] = {
    {"f8", 8, TOLIMAN_PIXEL_F64},      {"i8", 8, TOLIMAN_PIXEL_F64},      {"u8", 8, TOLIMAN_PIXEL_F64},
    {"f4", 4, TOLIMAN_PIXEL_F32},      {"b1", 1, TOLIMAN_PIXEL_U8},       {"u1", 1, TOLIMAN_PIXEL_U8},
    {"u2", 2, TOLIMAN_PIXEL_U16},      {"u4", 4, TOLIMAN_PIXEL_U32},      {"i2", 2, TOLIMAN_PIXEL_I16},
    {"i4", 4, TOLIMAN_PIXEL_I32},      {"u16le", 2, TOLIMAN_PIXEL_U16},   {"u32le", 4, TOLIMAN_PIXEL_U32},
    {"i16le", 2, TOLIMAN_PIXEL_I16},   {"f32le", 4, TOLIMAN_PIXEL_F32},   {"u16be", 2, TOLIMAN_PIXEL_U16BE},
    {"u32be", 4, TOLIMAN_PIXEL_U32BE}, {"i16be", 2, TOLIMAN_PIXEL_I16BE}, {"f32be", 4, TOLIMAN_PIXEL_F32BE},
};

bool is_headerless(const PixelType &type) noexcept {
    return std::strlen(type.name) > 2;
}

const PixelType &type_of(const std::string &name) noexcept {
    return *std::find_if(std::begin(kPixelTypes), std::end(kPixelTypes),
                         [&name](const PixelType &type) { return name == type.name; });
}

// Pixels after a .npy header, little-endian, or without header.
class PlainFrames final : public FrameFile {
  public:
    explicit PlainFrames(const std::string &path) : FrameFile(path), file_(open_input(path)) {
        path_ = file_.path();
        const toliman::NpyHeader header = read_npy_header(file_);
        type_ = type_of(header.type);
        start_ = header.size;
        set_axes(header.shape);
        check_size();
    }

    PlainFrames(const std::string &path, const std::string &dtype, size_t rows, size_t cols)
        : FrameFile(path), file_(open_input(path)), type_(type_of(dtype)) {
        path_ = file_.path();
        const size_t frame = rows * cols * type_.width;
        if (file_.ended())
            malformed(path_, "is empty");
        if (file_.size() % frame != 0)
            malformed(path_, "has " + std::to_string(file_.size()) + " bytes: must be a multiple of " +
                                 std::to_string(frame) + ", the size of a frame of " + shape_text(rows, cols) +
                                 narrow_frames(frame) + kind_of(path_));
        set_axes({file_.sized() ? file_.size() / frame : kMostFrames, rows, cols});
        check_size();
    }

    int32_t pixel() const noexcept override { return type_.pixel; }
    size_t frame_size() const noexcept override { return rows() * cols() * type_.width; }
    bool counted() const noexcept override { return file_.sized() || start_ > 0; }
    bool more() override {
        if (!counted())
            return !file_.ended();
        if (FrameFile::more())
            return true;
        if (!file_.sized() && !file_.ended())
            malformed(path_, "has more than " + std::to_string(count()) + " frames of " + shape_text(rows(), cols()));
        return false;
    }

  private:
    // A hint if the file has a whole number of frames as u16 instead of u32.
    std::string narrow_frames(size_t frame) const {
        const std::string name = type_.name;
        const size_t half = frame / 2;
        return name.substr(0, 3) != "u32" || file_.size() % half != 0
                   ? ""
                   : "; with --dtype u16" + name.substr(3) + " it has " + std::to_string(file_.size() / half) +
                         " frames";
    }

    // The sides are bounded, so that nothing here overflows.
    void check_size() const {
        const size_t size = start_ + count() * frame_size();
        if (file_.sized() && size != file_.size())
            malformed(path_, "has " + std::to_string(file_.size()) + " bytes: must have " + std::to_string(size) +
                                 " for " + std::to_string(count()) + " frames of " + shape_text(rows(), cols()));
    }

    // A number of 64 bits becomes a double in place.
    void load(size_t frame, void *pixels) override {
        if (file_.sized())
            file_.seek(start_ + frame * frame_size());
        if (!file_.read(pixels, frame_size()))
            malformed(path_, "ends within a frame of " + shape_text(rows(), cols()) + " pixels of " +
                                 std::to_string(type_.width) + " bytes");
        if (type_.width == sizeof(double))
            toliman::convert_npy(type_.name, static_cast<const unsigned char *>(pixels), rows() * cols(),
                                 static_cast<double *>(pixels));
    }

    InputFile file_;
    PixelType type_ = {};
    size_t start_ = 0; // offset of the pixels in the file
};

constexpr const char kSide[] = "_meta.jsonl", kPixels[] = "_frames.bin", kBatch[] = ".nc";
constexpr int kMostLines = 100;       // that are tried, as the first ones may be damaged
constexpr size_t kLongestLine = 4096; // of a side file

// Method: a child process reads the file and tells by its end whether that was possible, so that one damaged file does
// not end a run of many. netCDF is loaded before, once for all children.

[[noreturn]] void read_and_exit(const std::string &path) noexcept {
    const rlimit no_core = {0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    const int null = ::open("/dev/null", O_WRONLY);
    ::dup2(null, STDERR_FILENO); // what the C library says of a damaged heap
    auto options = toliman::sized<toliman_ingest_options>();
    options.pixel = TOLIMAN_PIXEL_U16;
    toliman_ingest *reader = nullptr;
    toliman_status status = toliman_ingest_create(path.c_str(), &options, &reader);
    auto event = toliman::sized<toliman_ingest_event>();
    while (status == TOLIMAN_OK && event.event != TOLIMAN_INGEST_EVENT_NOTHING) {
        auto frame = toliman::sized<toliman_frame>();
        event = toliman::sized<toliman_ingest_event>();
        status = toliman_ingest_next(reader, &frame, &event);
    }
    ::_exit(0);
}

// Orders names that end with a number by this: batch9999 is before batch10000.
struct InTime {
    bool operator()(const std::string &a, const std::string &b) const noexcept {
        return a.size() != b.size() ? a.size() < b.size() : a < b;
    }
};

} // namespace

std::vector<std::string> dtypes() {
    std::vector<std::string> names;
    for (const PixelType &type : kPixelTypes)
        if (is_headerless(type))
            names.push_back(type.name);
    return names;
}

std::optional<int64_t> ns_of_days(double days) {
    constexpr double kMostDays = 100000; // 9.2e18 ns are 106751 days
    if (!(std::fabs(days) <= kMostDays))
        return std::nullopt;
    const double whole = std::floor(days);
    return static_cast<int64_t>(whole) * 86400000000000 + std::llround((days - whole) * 86400e9);
}

bool is_fits(const std::string &path) {
    return ends_with(path, ".fits") || ends_with(path, ".fits.fz") || ends_with(path, ".fits.gz");
}

bool is_whole_number(const std::string &text, int64_t &value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    constexpr int64_t kMost = int64_t{1} << 62;
    return error == std::errc() && end == text.data() + text.size() && value >= -kMost && value <= kMost;
}

void FrameFile::set_axes(const std::vector<size_t> &axes) {
    if (axes.size() != 2 && axes.size() != 3)
        malformed(path_,
                  "has " + std::to_string(axes.size()) + (axes.size() == 1 ? " axis" : " axes") + ": must have 2 or 3");
    axes_ = axes;
    if (count() == 0)
        malformed(path_, "contains no frames");
    if (rows() == 0 || cols() == 0 || rows() > kLargestSide || cols() > kLargestSide || count() > kMostFrames)
        malformed(path_, std::to_string(count()) + " frames of " + shape_text(rows(), cols()) + ": must be at most " +
                             std::to_string(kMostFrames) + " frames with sides of 1 to " +
                             std::to_string(kLargestSide));
}

std::optional<size_t> FrameFile::read_values(double *image) {
    const auto is_read = [this](const PixelType &type) { return type.pixel == pixel(); };
    const PixelType &type = *std::find_if(std::begin(kPixelTypes), std::end(kPixelTypes), is_read);
    raw_.resize(frame_size());
    read(raw_.data());
    toliman::convert_npy(type.name, raw_.data(), rows() * cols(), image);
    for (size_t i = 0; i < rows() * cols(); i++)
        if (!std::isfinite(image[i]))
            return i;
    return std::nullopt;
}

void FrameFile::read_finite(double *image) {
    if (const auto blank = read_values(image))
        malformed(path_, "frame " + std::to_string(next_ - 1) + ", " + blank_text(*blank, cols()));
}

std::string blank_text(size_t pixel, size_t cols) {
    return "row " + std::to_string(pixel / cols) + ", column " + std::to_string(pixel % cols) +
           ": must be a finite number, not blank or NaN";
}

std::unique_ptr<FrameFile> open_frames(const std::string &path, const std::string &dtype, size_t rows, size_t cols,
                                       const std::string &unit) {
    if ((ends_with(path, ".npy") || is_fits(path)) && (!dtype.empty() || rows != 0))
        throw Failure(kExitUsage, path + ": --dtype and --shape are for files without header; this one has a header");
    if (ends_with(path, ".npy") || (path == "-" && dtype.empty() && rows == 0))
        return std::make_unique<PlainFrames>(path);
    if (is_fits(path))
        return open_fits(path, unit);
    const InputFile opened = open_input(path); // a missing file is reported before missing options
    if (dtype.empty())
        throw Failure(kExitUsage, path +
                                      ": a file without header needs --dtype, e.g. u16be or u32le, and --shape "
                                      "ROWSxCOLS" +
                                      kind_of(path));
    if (rows == 0 || cols == 0)
        throw Failure(kExitUsage, path + ": a file without header needs --shape ROWSxCOLS");
    return std::make_unique<PlainFrames>(path, dtype, rows, cols);
}

bool is_pair(const std::string &path) {
    return ends_with(path, kSide) || ends_with(path, kPixels);
}

bool is_batch(const std::string &path) {
    return ends_with(path, kBatch);
}

int32_t pixel_of_pair(const std::string &path, const std::string &dtype) {
    if (is_batch(path))
        return 0;
    if (!dtype.empty() && dtype != "u16le" && dtype != "u32le")
        throw Failure(kExitUsage, path + ": --dtype " + dtype + ": must be u16le or u32le for raw pairs");
    return dtype.empty() ? 0 : dtype == "u32le" ? TOLIMAN_PIXEL_U32 : TOLIMAN_PIXEL_U16;
}

std::string other_file(const std::string &path) {
    const bool is_side = ends_with(path, kSide);
    return path.substr(0, path.size() - std::strlen(is_side ? kSide : kPixels)) + (is_side ? kPixels : kSide);
}

std::string side_of(const std::string &path) {
    return ends_with(path, kSide) ? path : other_file(path);
}

bool is_dated_file(const std::string &path) {
    return ends_with(path, ".npy") || is_fits(path);
}

std::vector<std::string> files_of(const std::string &path) {
    std::error_code error;
    std::set<std::string> pairs;
    std::set<std::string, InTime> batches, fits;
    for (std::filesystem::directory_iterator entry(path, error), end; entry != end; entry.increment(error)) {
        const std::string name = entry->path().filename().native(), file = plain(path) + "/" + name;
        if (is_pair(name))
            pairs.insert(side_of(file));
        else if (is_batch(name))
            batches.insert(file);
        else if (is_fits(name))
            fits.insert(file);
    }
    if (error)
        malformed(path, error.message());
    if (!pairs.empty())
        return {pairs.begin(), pairs.end()};
    const auto &files = !batches.empty() ? batches : fits;
    return {files.begin(), files.end()};
}

std::vector<std::string> files_in(const std::string &input) {
    return is_folder(input) ? files_of(input) : std::vector<std::string>{input};
}

void check_complete(const std::string &side) {
    for (const std::string &path : {side, other_file(side)})
        if (!exists(path))
            malformed(path, std::strerror(errno) +
                                std::string(exists(other_file(path)) ? ", required next to " + other_file(path) : ""));
}

std::string region_of(const std::string &side) {
    std::ifstream file(side);
    std::string line(kLongestLine, '\0');
    for (int i = 0; i < kMostLines && file.getline(line.data(), static_cast<std::streamsize>(line.size())); i++) {
        const JsonTree tree(cJSON_Parse(line.c_str()));
        const cJSON *const roi = cJSON_GetObjectItemCaseSensitive(tree.get(), "roi_label");
        if (cJSON_IsString(roi))
            return roi->valuestring;
    }
    return "";
}

bool has_stamps(const std::vector<std::string> &inputs) {
    return std::any_of(inputs.begin(), inputs.end(), [](const std::string &input) {
        const std::vector<std::string> files = files_in(input);
        return files.empty() || !is_dated_file(files.front());
    });
}

void check_one_region(const std::vector<std::string> &inputs) {
    std::set<std::string> regions;
    for (const std::string &input : inputs)
        try {
            for (const std::string &file : files_in(input))
                if (is_pair(file))
                    regions.insert(region_of(side_of(file)));
        } catch (const Failure &) { // a folder that cannot be read is reported later
        }
    regions.erase("");
    if (regions.size() < 2)
        return;
    throw Failure(kExitUsage, (inputs.size() == 1 ? inputs.front() : "the inputs") + ": frames of the regions " +
                                  joined({regions.begin(), regions.end()}) + ": --roi LABEL takes those of one");
}

void probe_batch(const std::string &path) {
    if (toliman_ingest_netcdf_version()[0] == '\0')
        return;
    const pid_t child = ::fork();
    if (child == 0)
        read_and_exit(path);
    int status = 0;
    while (child > 0 && ::waitpid(child, &status, 0) < 0 && errno == EINTR)
        ;
    if (child > 0 && WIFSIGNALED(status))
        malformed(path, "is damaged: netCDF crashes on it");
}

} // namespace cli
