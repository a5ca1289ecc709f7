#include "frames/frame_options.hpp"

#include "frames/frames_in.hpp"
#include "frames/predictions.hpp"
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

void FrameOptions::add_to(CLI::App &command) {
    command.add_option("--cadence", cadence)->check(CLI::PositiveNumber);
    add_choice(&command, "--dtype", dtype, dtypes());
    add_option(&command, "--shape", shape, "ROWSxCOLS");
    add_option(&command, "--roi", roi, "LABEL");
    command.add_option("--exposure", exposure_s)->check(CLI::Range(0.0, 1e9));
    add_choice(&command, "--stamp", stamp, {std::begin(kStamps), std::end(kStamps)});
    add_option(&command, "--hdu", unit, "NAME");
    add_option(&command, "FRAMES", files, "")->required();
}

std::vector<std::string> FrameOptions::inputs() const {
    if (roi.empty())
        check_one_region(files);
    std::vector<std::string> all;
    const auto is_other = [this](const std::string &file) {
        return !roi.empty() && is_pair(file) && region_of(file) != roi;
    };
    for (const std::string &file : files) {
        std::vector<std::string> more = files_in(file);
        if (is_folder(file))
            more.erase(std::remove_if(more.begin(), more.end(), is_other), more.end());
        if (more.empty())
            malformed(file, "contains no pairs, X_frames.bin and X_meta.jsonl, and no .nc and FITS files" +
                                (roi.empty() ? "" : ", of the region " + roi));
        all.insert(all.end(), more.begin(), more.end());
    }
    return all;
}

std::unique_ptr<FrameFile> FrameOptions::open(const std::string &path, double scene_exposure_s) const {
    if (is_pair(path))
        check_complete(side_of(path));
    if (is_pair(path) || is_batch(path)) {
        auto options = toliman::sized<toliman_ingest_options>();
        options.pixel = pixel_of_pair(path, dtype);
        options.exposure_s = exposure_s.value_or(scene_exposure_s);
        options.stamp = stamp_of(stamp);
        options.roi = roi.empty() ? nullptr : roi.c_str();
        return open_mission(path, options);
    }
    int64_t rows, cols;
    shape_of(shape, rows, cols);
    return open_frames(path, dtype, static_cast<size_t>(rows), static_cast<size_t>(cols), unit);
}

} // namespace cli
