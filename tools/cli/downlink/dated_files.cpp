#include "downlink/dated_files.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "common/failure.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr const char kRoi[] = "single_roi"; // the mission's name of the only region

// The file's name without folder and suffix.
std::string name_of(const std::string &path) {
    std::string name = path.substr(path.rfind('/') + 1);
    for (const char *suffix : {".npy", ".fits", ".fits.fz"})
        if (ends_with(name, suffix))
            return name.substr(0, name.size() - std::strlen(suffix));
    return name;
}

bool whole_number(const std::string &text, int64_t &value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    constexpr int64_t kMost = int64_t{1} << 62;
    return error == std::errc() && end == text.data() + text.size() && value >= -kMost && value <= kMost;
}

bool is_session_name(const std::string &text) {
    return !text.empty() && text.size() <= 64 && text[0] != '.' &&
           text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") ==
               std::string::npos;
}

} // namespace

bool is_dated_file(const std::string &path) {
    return ends_with(path, ".npy") || is_fits(path);
}

// Files of one session are distinguished by their key FRAME1, never by the order in which they arrive.
DatedFiles::Identity DatedFiles::identity_of(FrameFile &file) {
    const std::string &path = file.path(), &session = options_.session;
    const std::optional<std::string> number = file.value_of("FRAME1");
    Identity identity = {session.empty() ? name_of(path) : session, 0};
    if (!is_session_name(identity.session))
        malformed(path, "session " + identity.session +
                            ": must have 1 to 64 characters A-Z a-z 0-9 . _ - and not begin with a dot");
    if (!session.empty() && !number) {
        if (!unnumbered_.empty() && unnumbered_ != path)
            malformed(path, "has no key FRAME1, the number of its first frame: --session " + session +
                                " cannot distinguish it from " + unnumbered_);
        unnumbered_ = path;
    }
    if (number && !whole_number(*number, identity.first_id))
        malformed(path, "FRAME1 = " + *number + ": must be a whole number from -2^62 to 2^62");
    return identity;
}

FrameTimes DatedFiles::times_of(FrameFile &file, const Identity &identity) {
    FrameTimes times(file, identity.first_id, options_.cadence, options_.leap_seconds);
    const std::string &path = file.path();
    if (times.is_tai() && tracking_.settings().clock_points > 0)
        throw Failure(kExitUsage,
                      path + ": its time (" + times.rule() +
                          ") is TAI, but the state folder has a clock table: give a folder without --clock");
    if (is_fits(path))
        tracking_.report(times.assumed() ? Severity::warning : Severity::note, "time", path, "time by " + times.rule());
    if (times.beyond() && !std::exchange(warned_of_expiry_, true))
        tracking_.report(Severity::warning, "time", path,
                         "leap seconds are known up to MJD " + std::to_string(options_.leap_seconds.expires) +
                             " only: --leap-seconds FILE reads a newer leap-seconds.list of the IERS");
    if (times.by_cadence())
        warn_of_overlap(file, identity, times);
    return times;
}

// The same frames again have the same times.
void DatedFiles::warn_of_overlap(const FrameFile &file, const Identity &identity, const FrameTimes &times) {
    const size_t last = file.count() - 1;
    const int64_t first_id = identity.first_id;
    const CadenceSpan span = {file.path(), identity.session, first_id, first_id + static_cast<int64_t>(last),
                              times.at(0), times.at(last)};
    const auto has_frames = [&span](const CadenceSpan &other) {
        return span.session == other.session && span.first_id <= other.last_id && other.first_id <= span.last_id;
    };
    const auto overlaps = [&span](const CadenceSpan &other) {
        return span.first_ns <= other.last_ns && other.first_ns <= span.last_ns;
    };
    if (std::any_of(spans_.begin(), spans_.end(), has_frames))
        return;
    const auto other = std::find_if(spans_.begin(), spans_.end(), overlaps);
    if (other != spans_.end())
        tracking_.report(Severity::warning, "same times", span.path,
                         "its times by --cadence overlap those of " + other->path +
                             ": FRAME1 or a time in the header of a FITS file distinguishes them");
    spans_.push_back(span);
}

std::shared_ptr<FrameSource> DatedFiles::open(const std::string &path, const FrameIds &wanted) {
    auto file = open_frames(path);
    const Identity identity = identity_of(*file);
    const FrameTimes times = times_of(*file, identity);
    return std::make_shared<FileSource>(std::move(file), tracking_.batch(),
                                        [identity, times, wanted](size_t k, toliman_frame &frame) {
                                            frame.session = identity.session.c_str();
                                            frame.roi = kRoi;
                                            frame.frame_id = identity.first_id + static_cast<int64_t>(k);
                                            frame.camera_ns = times.at(k);
                                            return frame.frame_id >= wanted.first && frame.frame_id < wanted.end;
                                        });
}

} // namespace cli
