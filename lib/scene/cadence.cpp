#include <algorithm>
#include <charconv>
#include <cmath>

#include "backend/erfa.hpp"
#include "backend/file.hpp"
#include "ingest/on_target_table.hpp"
#include "scene/groups.hpp"

namespace toliman::scene {

namespace {

constexpr double kMostFrames = 1e7;
constexpr Range kTime = within(-1e9, 1e9, "days");
constexpr size_t kLargestTimes = size_t{512} << 20;

// Times from a file, one per line; blank lines and lines that begin with # are skipped.
std::vector<double> times_in(const std::string &path) {
    const std::vector<uint8_t> bytes = file::read(path, kLargestTimes);
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

void read_times(const Reader &reader, const Row &row, Cadence &cadence) {
    cadence.times_days = reader.has_text(row.key) ? times_in(reader.file(row.key)) : reader.numbers(row);
    cadence.frames = static_cast<int64_t>(cadence.times_days.size());
}

// Checked after the exposure is known.
void read_on_target(const Reader &reader, const Row &row, Cadence &cadence) {
    const std::vector<double> times = reader.numbers(row);
    if (times.size() % 2 != 0)
        reader.refuse(Status::scene, row.key, ": has %zu numbers: must have a start and an end of each interval",
                      times.size());
    for (size_t i = 1; i < times.size(); i++)
        if (!(times[i] > times[i - 1]))
            reader.refuse(Status::scene, row.key, "[%zu] = %g: must be above the number before it", i, times[i]);
    if (!(times.back() <= cadence.exposure_s))
        reader.refuse(Status::scene, row.key, ": ends at %g s: must end within exposure_s", times.back());
    cadence.on_target_s = times;
}

// Read after the frames and the binary. The light of a frame is proportional to its time on target. That of the scene
// is the light of the first frame with some, which stays the same while the table grows with the mission.
void read_windows(const Reader &reader, Cadence &cadence) {
    constexpr const char *kKey = "on_target";
    constexpr double kFarthest = 73000; // days, within 64 bits of nanoseconds
    const int64_t zero_ns = time_zero_ns(reader.scene().binary);
    if (zero_ns == 0)
        reader.refuse(Status::scene, kKey, ": needs stars that move from binary.date on");
    if (!cadence.on_target_s.empty())
        reader.refuse(Status::scene, kKey, ": not allowed with on_target_s");
    for (const ingest::OnTargetWindow &window :
         ingest::read_on_target(cadence.windows_file, ingest::LeapSeconds(erfa::leap_seconds().rows)))
        cadence.windows.push_back({window.start_ns, window.end_ns});
    if (longest_days(cadence) > kFarthest)
        reader.refuse(Status::scene, kKey, ": frames must be within %g days of time 0", kFarthest);
    for (int64_t k = 0; k < cadence.frames && cadence.windows_s == 0; k++)
        cadence.windows_s = seconds_of(exposure_at(cadence, zero_ns, time_days(cadence, k)));
    if (cadence.windows_s == 0)
        reader.refuse(Status::scene, kKey, ": %s has no window in the exposure of any frame",
                      cadence.windows_file.c_str());
}

constexpr Condition kRegular = without("times_days", "not allowed with times_days, which gives all times");

constexpr Row kCadenceRows[] = {
    required<&Cadence::frames>("frames", within(1, kMostFrames, "frames"), "Number of frames").when(kRegular),
    optional<&Cadence::interval_days>("interval_days", above(0, 1e6, "days"),
                                      "Time between frames; frame k is at k times this")
        .when(kRegular),
    optional<read_times>("times_days", kTime,
                         "Times of the frames in any order, or a file with one time per line, instead of frames and "
                         "interval_days")
        .as(Type::numbers_or_file)
        .entries(1, 4096),
    required<&Cadence::peak_photons>("peak_photons", within(kFewestPhotons, 1e12, "photons"),
                                     "Photons in the brightest pixel of the frame without displacement; scales the "
                                     "stars' fluxes")
        .either("exposure_s"),
    optional<&Cadence::exposure_s>(
        "exposure_s", above(0, 1e9, "s"),
        "Exposure of a frame; every star then needs photons_per_s, detected_per_s or magnitude; the expected peak must "
        "be at least 1e-6 photons"),
    optional<read_on_target>("on_target_s", within(0, 1e9, "s"),
                             "Intervals from the start of an exposure in which the telescope points at the stars: "
                             "start and end of each in turn. Photons are collected in them only. The stars are at "
                             "their mean places over them")
        .as(Type::numbers)
        .entries(2, 4096)
        .when(with("exposure_s", "needs exposure_s")),
    optional<&Cadence::windows_file>("on_target",
                                     "Table of on-target windows (formats.md), instead of on_target_s: the telescope "
                                     "points at the stars in those within an exposure, and its photons are in "
                                     "proportion to their time")
        .when(with("exposure_s", "needs exposure_s"))
        .checked<read_windows>(),
};

} // namespace

constexpr Group kCadence = group_of("cadence", "Frames", kCadenceRows);

} // namespace toliman::scene
