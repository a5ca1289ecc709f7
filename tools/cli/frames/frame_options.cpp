#include "frames/frame_options.hpp"

#include <algorithm>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

void shape_of(const std::string &text, int64_t &rows, int64_t &cols) {
    rows = cols = 0;
    if (!text.empty() &&
        (!two_numbers(text, 'x', rows, cols) || std::min(rows, cols) < 1 || std::max(rows, cols) > 65536))
        throw Failure(kExitUsage, "--shape " + text + ": must be ROWSxCOLS, e.g. 256x256");
}

} // namespace

void FrameOptions::add_to(CLI::App &command, const char *cadence_text) {
    command.add_option("--cadence", cadence, cadence_text)->check(CLI::PositiveNumber);
    add_choice(&command, "--dtype", dtype, dtypes(),
               "pixel type of files without header: u16le, u32le, i16le, f32le, or big-endian u16be, u32be, "
               "i16be, f32be");
    add_option(&command, "--shape", shape, "ROWSxCOLS", "size of the frames in files without header: ROWSxCOLS");
    add_option(&command, "--hdu", unit, "NAME",
               "name or number of the HDU of FITS files, 0 for the primary one; default: CORE, or the first with pixels");
    add_option(&command, "FRAMES", files, "",
               ".npy and FITS files, or files without header with --dtype and --shape; - reads standard input")
        ->required();
}

std::unique_ptr<FrameFile> FrameOptions::open(const std::string &path) const {
    int64_t rows, cols;
    shape_of(shape, rows, cols);
    return open_frames(path, dtype, static_cast<size_t>(rows), static_cast<size_t>(cols), unit);
}

} // namespace cli
