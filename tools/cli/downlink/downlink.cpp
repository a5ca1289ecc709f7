#include "downlink/downlink.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <dirent.h>
#include <memory>
#include <poll.h>

#include <toliman/track.h>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/lines.hpp"
#include "common/text.hpp"
#include "frames/frames_in.hpp"

namespace cli {

namespace {

constexpr int kPollMs = 1000;
constexpr const char kRoi[] = "single_roi"; // as the mission calls it where there is but one

bool is_cube(const std::string &path) {
    return ends_with(path, ".npy") || is_fits(path);
}

// The file's name without folder and suffix.
std::string session_of(const std::string &path) {
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

struct CloseFolder {
    void operator()(DIR *folder) const noexcept { ::closedir(folder); }
};

// Side files of a folder, in the order of their names, and binaries that have none.
std::vector<std::string> pairs_of(const std::string &path) {
    const std::unique_ptr<DIR, CloseFolder> folder(::opendir(path.c_str()));
    if (!folder)
        malformed(path, std::strerror(errno));
    std::set<std::string> sides;
    while (const dirent *entry = ::readdir(folder.get()))
        if (is_pair(entry->d_name))
            sides.insert(side_of(plain(path) + "/" + entry->d_name));
    return {sides.begin(), sides.end()};
}

// A Failure of one of the two files that is not there.
void check_whole(const std::string &side) {
    const std::string binary = binary_of(side);
    for (const auto &[path, other] : {std::pair(side, binary), std::pair(binary, side)})
        if (!exists(path))
            malformed(path, std::strerror(errno) + std::string(exists(other) ? ", wanted beside " + other : ""));
}

// What a Failure tells of an input, without its name.
std::string reason_of(const Failure &failure, const std::string &input) {
    const std::string text = failure.what();
    return text.rfind(input + ": ", 0) == 0 ? text.substr(input.size() + 2) : text;
}

} // namespace

void check_inputs(const DownlinkOptions &options) {
    for (const std::string &input : options.inputs) {
        if (input == "-" && (options.inputs.size() > 1 || options.follow))
            throw Failure(kExitUsage, options.follow ? "-: standard input goes on by itself, without --follow"
                                                     : "-: standard input stands alone");
        if (input == "-")
            continue;
        if (!exists(input))
            malformed(input, std::strerror(errno));
        if (is_cube(input) && options.follow)
            throw Failure(kExitUsage, input + ": --follow is for folders and for pairs");
        if (ends_with(input, ".npy") && !options.cadence)
            throw Failure(kExitUsage, input + ": a file without times needs --cadence SECONDS");
        if (!is_folder(input) && !is_pair(input) && !is_cube(input))
            throw Failure(kExitUsage,
                          input + ": must be X_frames.bin, X_meta.jsonl, .npy, .fits, .fits.fz or a folder");
        if (!is_cube(input) && options.dtype.empty())
            throw Failure(kExitUsage, input + ": headerless frames need --dtype u16le or u32le");
        if (is_pair(input) && !options.follow)
            check_whole(side_of(input));
    }
}

void Downlink::read() {
    if (options_.inputs.front() == "-")
        return read_names();
    if (!options_.follow) {
        for (const std::string &input : options_.inputs)
            read_input(input);
        return;
    }
    try {
        for (;;)
            poll();
    } catch (const Failure &) {
        end();
        throw;
    }
}

void Downlink::read_names() {
    LineSource names("-", [this] { receiver_.wait(); });
    for (std::string name; names.next(name);) {
        if (!name.empty() && name.back() == '\r')
            name.pop_back();
        if (!name.empty())
            read_input(name);
    }
}

// An input that cannot be read does not end the others.
void Downlink::read_input(const std::string &name) {
    try {
        if (is_folder(name))
            read_folder(name);
        else if (is_pair(name))
            read_pair(name);
        else if (is_cube(name))
            read_cube(name);
        else
            malformed(name, exists(name) ? "is no X_frames.bin, X_meta.jsonl, .npy, .fits, .fits.fz or folder"
                                         : std::strerror(ENOENT));
    } catch (const Failure &failure) {
        if (failure.code() != kExitInput)
            throw;
        receiver_.remark(Remark::unreadable, name, reason_of(failure, name));
    }
}

void Downlink::read_folder(const std::string &folder) {
    const std::vector<std::string> sides = pairs_of(folder);
    if (sides.empty())
        receiver_.tell("empty folder", folder,
                       "holds neither X_frames.bin nor X_meta.jsonl; .npy and FITS files are given by their names",
                       true);
    for (const std::string &side : sides)
        read_input(side);
}

void Downlink::read_pair(const std::string &path) {
    if (options_.dtype.empty())
        malformed(path, "headerless frames need --dtype u16le or u32le");
    check_whole(side_of(path));
    Pair pair(path, {options_.dtype == "u32le", options_.rows, options_.cols});
    pair.read(receiver_, false);
    pair.end(receiver_);
}

// Of the first frame, but for its time. Files of one session are told apart by their key FRAME1, never by the order in
// which they come.
FrameFacts Downlink::facts_of(FrameFile &file) {
    const std::optional<std::string> number = file.value_of("FRAME1");
    FrameFacts facts = {session_of(file.path()), kRoi, 0, 0, 0, file.rows(), file.cols()};
    if (!options_.session.empty()) {
        if (!number && !unnumbered_.empty() && unnumbered_ != file.path())
            malformed(file.path(), "has no key FRAME1, the number of its first frame: --session " + options_.session +
                                       " cannot tell it from " + unnumbered_);
        if (!number)
            unnumbered_ = file.path();
        facts.session = options_.session;
    }
    check_name(facts.session, file.path());
    if (number && !whole_number(*number, facts.id))
        malformed(file.path(), "FRAME1 = " + *number + ": must be a whole number, at most 2^62 either way");
    return facts;
}

FrameTimes Downlink::times_of(FrameFile &file, const FrameFacts &first) {
    FrameTimes times(file, first.id, options_.cadence, options_.leap_seconds);
    if (times.is_tai() && options_.clock)
        throw Failure(kExitUsage, file.path() + ": its time (" + times.rule() +
                                      ") becomes TAI by itself, and the folder has a clock: must be a folder without "
                                      "--clock");
    if (is_fits(file.path()))
        receiver_.tell("time", file.path(), "time by " + times.rule(), times.assumed());
    if (times.beyond() && !told_beyond_)
        receiver_.tell("time", file.path(),
                       "leap seconds are known up to MJD " + std::to_string(options_.leap_seconds.expires) +
                           " only: --leap-seconds FILE takes a newer leap-seconds.list of the IERS",
                       true);
    told_beyond_ = told_beyond_ || times.beyond();
    if (times.by_cadence())
        remark_overlap(file, first, times);
    return times;
}

// The same frames again have the same times.
void Downlink::remark_overlap(const FrameFile &file, const FrameFacts &first, const FrameTimes &times) {
    const size_t last = file.count() - 1;
    const CadenceSpan span = {file.path(), first.session, first.id, first.id + static_cast<int64_t>(last),
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
        receiver_.tell("same times", span.path,
                       "its times by --cadence overlap those of " + other->path +
                           ": FRAME1 or a time in the header of a FITS file sets it apart",
                       true);
    spans_.push_back(span);
}

void Downlink::read_cube(const std::string &path) {
    const auto file = open_frames(path);
    FrameFacts facts = facts_of(*file);
    const FrameTimes times = times_of(*file, facts);
    const size_t pixels = file->rows() * file->cols();
    for (size_t k = 0; k < file->count(); k++, facts.id++) {
        facts.camera_ns = times.at(k);
        if (!receiver_.wants(facts)) {
            file->skip();
            continue;
        }
        Arrival &arrival = receiver_.next();
        std::vector<double> image(pixels);
        file->read_any(image.data());
        arrival.pixels.resize(pixels * sizeof image[0]);
        std::memcpy(arrival.pixels.data(), image.data(), arrival.pixels.size());
        arrival.pixel = TOLIMAN_PIXEL_F64;
        arrival.where = path + ":" + std::to_string(k);
        arrival.facts = facts;
        receiver_.take();
    }
}

std::vector<std::string> Downlink::open_sides(const std::string &input) const {
    if (!is_pair(input))
        return pairs_of(input);
    const std::string side = side_of(input);
    if (growing_.count(side) > 0)
        check_whole(side);
    return {side};
}

// Side files of an input that is followed. Says once that it cannot be opened, and that it is back.
std::vector<std::string> Downlink::sides_of(const std::string &input) {
    std::vector<std::string> sides;
    std::string why;
    try {
        sides = open_sides(input);
    } catch (const Failure &failure) {
        why = reason_of(failure, input);
    }
    if (!why.empty() && gone_.insert(input).second)
        receiver_.remark(Remark::unreadable, input, "is gone, and waited for: " + why);
    if (why.empty() && gone_.erase(input) > 0)
        receiver_.tell("back", input, "is back", false);
    return sides;
}

void Downlink::look_at(const std::string &side) {
    if (!exists(side) || !exists(binary_of(side))) { // yet
        halves_[side]++;
        return;
    }
    const PairFormat format = {options_.dtype == "u32le", options_.rows, options_.cols};
    Pair &pair = growing_.try_emplace(side, side, format).first->second;
    try {
        pair.read(receiver_, true);
    } catch (const Failure &failure) {
        if (failure.code() != kExitInput)
            throw;
        if (mute_.insert(side).second)
            receiver_.remark(Remark::unreadable, side, reason_of(failure, side));
    }
}

void Downlink::poll() {
    for (const std::string &input : options_.inputs)
        for (const std::string &side : sides_of(input))
            look_at(side);
    receiver_.wait();
    ::poll(nullptr, 0, kPollMs); // a signal ends it
    receiver_.wait();
}

void Downlink::end() {
    for (auto &[side, pair] : growing_)
        pair.end(receiver_);
    for (const std::string &input : options_.inputs)
        for (const std::string &side : sides_of(input))
            name_half(side);
}

// A pair of which only one file ever came. What one look found may be on its way.
void Downlink::name_half(const std::string &side) {
    if (growing_.count(side) > 0 || halves_[side] < 2)
        return;
    try {
        check_whole(side);
    } catch (const Failure &failure) {
        receiver_.remark(Remark::unreadable, side, reason_of(failure, side));
    }
}

} // namespace cli
