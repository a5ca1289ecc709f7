#include <algorithm>
#include <charconv>
#include <cmath>

#include "backend/file.hpp"
#include "optics/scene_groups.hpp"

namespace toliman::optics {

namespace {

constexpr double kMostFrames = 1e7;
constexpr Range kTime = within(-1e9, 1e9, "days");
constexpr size_t kLargestFile = size_t{512} << 20;

// Times from a file, one per line; blank lines and lines that begin with # are skipped.
std::vector<double> times_in(const std::string &path) {
    const std::vector<uint8_t> bytes = file::read(path, kLargestFile);
    const std::string text(bytes.begin(), bytes.end());
    constexpr const char *blanks = " \t\r";
    std::vector<double> times;
    for (size_t start = 0, number = 1; start < text.size(); number++) {
        const size_t stop = std::min(text.find('\n', start), text.size());
        std::string line = text.substr(start, stop - start);
        start = stop + 1;
        line.erase(0, line.find_first_not_of(blanks));
        line.erase(line.find_last_not_of(blanks) + 1);
        if (line.empty() || line[0] == '#')
            continue;
        double time = 0;
        const char *const end = line.data() + line.size();
        const auto [after, error] = std::from_chars(line.data(), end, time);
        if (error != std::errc() || after != end || !(std::fabs(time) <= kTime.high))
            fail(Status::format, "{%s}:%zu: \"%.40s\": must be a number in [%g, %g] days", path.c_str(), number,
                 line.c_str(), kTime.low, kTime.high);
        times.push_back(time);
    }
    if (times.empty() || times.size() > static_cast<size_t>(kMostFrames))
        fail(Status::format, "{%s}: contains %zu times: must be 1 to %.0f", path.c_str(), times.size(), kMostFrames);
    return times;
}

} // namespace

Cadence read_cadence(const Reader &scene, const std::vector<Star> &stars, const std::string &folder) {
    const Reader reader = scene.object("cadence");
    Cadence cadence;
    if (reader.has("times_days")) {
        reader.exclude({"frames", "interval_days"}, "not allowed with times_days, which gives all times");
        reader.allow({"times_days", "peak_photons", "exposure_s"});
        cadence.times_days = reader.has_text("times_days") ? times_in(reader.file("times_days", folder))
                                                           : reader.numbers("times_days", 1, 4096, kTime);
        cadence.frames = static_cast<int64_t>(cadence.times_days.size());
    } else {
        reader.allow({"frames", "interval_days", "times_days", "peak_photons", "exposure_s"});
        cadence.frames = reader.integer("frames", within(1, kMostFrames, "frames"));
        cadence.interval_days = reader.number_or("interval_days", 1, above(0, 1e6, "days"));
    }
    if (reader.has("peak_photons") == reader.has("exposure_s"))
        reader.refuse(Status::scene, "peak_photons", ": give either peak_photons or exposure_s");
    const auto has_flux = [](const Star &star) { return star.photons_per_s.has_value(); };
    if (reader.has("exposure_s")) {
        cadence.exposure_s = reader.number("exposure_s", above(0, 1e9, "s"));
        if (!std::all_of(stars.begin(), stars.end(), has_flux))
            reader.refuse(Status::scene, "exposure_s", ": needs photons_per_s for every star");
    } else {
        cadence.peak_photons = reader.number("peak_photons", within(kFewestPhotons, 1e12, "photons"));
        if (std::any_of(stars.begin(), stars.end(), has_flux) && !std::all_of(stars.begin(), stars.end(), has_flux))
            scene.refuse(Status::scene, "stars", ": give photons_per_s for both stars or neither");
    }
    return cadence;
}

} // namespace toliman::optics
