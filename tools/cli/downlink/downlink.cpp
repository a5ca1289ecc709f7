#include "downlink/downlink.hpp"

#include <cerrno>
#include <cstring>
#include <poll.h>
#include <sys/stat.h>
#include <tuple>
#include <utility>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/lines.hpp"
#include "common/stop.hpp"
#include "common/text.hpp"
#include "frames/batch_probe.hpp"
#include "frames/frame_files.hpp"

namespace cli {

namespace {

constexpr int kPollMs = 1000;
constexpr const char kUnreadable[] = "unreadable input";
constexpr const char kInputs[] = "must be X_frames.bin, X_meta.jsonl, .nc, .npy, .fits, .fits.fz, .fits.gz or a folder";
constexpr const char kNeedsDtype[] = "headerless frames need --dtype u16le or u32le";

// Why work() cannot read an input, without the name of the input; "" if it can.
template <class Work> std::string complaint_of(const std::string &input, Work work) {
    try {
        work();
        return "";
    } catch (const Failure &failure) {
        if (failure.code() != kExitInput)
            throw;
        const std::string text = failure.what(), name = input + ": ";
        return text.rfind(name, 0) == 0 ? text.substr(name.size()) : text;
    }
}

// A batch, or a folder of batches or FITS files.
bool has_whole_files(const std::string &input) {
    return is_batch(input) || (is_folder(input) && !files_of(input).empty() && !has_pairs(input));
}

} // namespace

void check_inputs(const InputOptions &options) {
    for (const std::string &input : options.inputs) {
        if (input == "-" && (options.inputs.size() > 1 || options.follow))
            throw Failure(kExitUsage, options.follow ? "-: standard input is read to its end, without --follow"
                                                     : "-: standard input must be the only input");
        if (input == "-")
            continue;
        if (!exists(input))
            malformed(input, std::strerror(errno));
        if (is_dated_file(input) && options.follow)
            throw Failure(kExitUsage, input + ": --follow is for folders, pairs and batches");
        if (ends_with(input, ".npy") && !options.dated.cadence)
            throw Failure(kExitUsage, input + ": a file without times needs --cadence SECONDS");
        if (!is_folder(input) && !is_pair(input) && !is_dated_file(input) && !is_batch(input))
            throw Failure(kExitUsage, input + ": " + kInputs);
        if ((has_pairs(input) || (options.follow && !has_whole_files(input))) && options.dtype.empty())
            throw Failure(kExitUsage, input + ": " + kNeedsDtype);
        if (is_pair(input) && !options.follow)
            check_complete(side_of(input));
    }
    if (options.roi.empty())
        check_one_region(options.inputs);
}

void Downlink::read() {
    if (options_.inputs.front() == "-")
        return read_names();
    if (options_.follow)
        return follow();
    for (const std::string &input : options_.inputs)
        read_input(input);
}

void Downlink::read_names() {
    LineSource names("-", [this] { sink_.wait(); });
    for (std::string name; names.next(name);) {
        if (!name.empty() && name.back() == '\r')
            name.pop_back();
        if (!name.empty())
            read_input(name);
    }
}

// An input that cannot be read does not end the run.
void Downlink::read_input(const std::string &name) {
    const std::string why = complaint_of(name, [&] {
        if (is_folder(name))
            read_folder(name);
        else if (is_pair(name))
            read_pair(name);
        else if (is_batch(name)) {
            probe_batch(name);
            drain(open_pair(name));
        } else if (is_dated_file(name))
            drain(dated_.open(name, options_.frames));
        else
            malformed(name, exists(name) ? kInputs : std::strerror(ENOENT));
    });
    if (!why.empty())
        sink_.report(Severity::damage, kUnreadable, name, why);
}

void Downlink::read_folder(const std::string &folder) {
    const std::vector<std::string> files = files_of(folder);
    if (files.empty())
        sink_.report(Severity::warning, "empty folder", folder,
                     "contains no pairs, X_frames.bin and X_meta.jsonl, and no .nc and FITS files; .npy files must "
                     "be named");
    for (const std::string &file : files)
        read_input(file);
}

void Downlink::read_pair(const std::string &path) {
    if (options_.dtype.empty())
        malformed(path, kNeedsDtype);
    check_complete(side_of(path));
    drain(open_pair(path));
}

std::shared_ptr<PairSource> Downlink::open_pair(const std::string &path) const {
    const toliman_track_options &settings = sink_.settings();
    auto options = toliman::sized<toliman_ingest_options>();
    options.flags = options_.follow ? TOLIMAN_INGEST_GROWING : 0;
    options.pixel = options_.dtype == "u32le" && !is_batch(path) ? TOLIMAN_PIXEL_U32 : TOLIMAN_PIXEL_U16;
    options.stamp = settings.frames.stamp;
    options.exposure_s = settings.frames.exposure_s;
    options.rows = settings.frames.rows;
    options.cols = settings.frames.cols;
    options.first_id = options_.frames.first;
    options.end_id = options_.frames.end;
    options.buffers = static_cast<uint32_t>(sink_.batch());
    options.roi = options_.roi.empty() ? nullptr : options_.roi.c_str();
    return std::make_shared<PairSource>(path, options);
}

// Gives all frames of a source to the sink.
void Downlink::drain(const std::shared_ptr<FrameSource> &source) {
    toliman_frame frame;
    toliman_ingest_event event;
    int64_t skipped = source->skipped();
    for (bool more = true; more;) {
        more = source->next(frame, event);
        const int64_t before = std::exchange(skipped, source->skipped());
        sink_.count_skipped(skipped - before);
        if (more)
            sink_.take(source, frame, event);
        if (more && !stopped_)
            stop_if_asked();
    }
}

void Downlink::read_growing(const std::string &side) {
    Growing &pair = growing_[side];
    if (!exists(side) || !exists(other_file(side))) { // yet
        pair.halves++;
        return;
    }
    pair.at_end = false;
    const std::string why = complaint_of(side, [&] {
        if (options_.dtype.empty())
            malformed(side, kNeedsDtype);
        if (!pair.source)
            pair.source = open_pair(side);
        drain(pair.source);
        pair.at_end = true;
    });
    if (!why.empty() && !std::exchange(pair.unreadable, true))
        sink_.report(Severity::damage, kUnreadable, side, why);
}

// A batch or FITS file that did not change between two checks, and has changed since it was read.
void Downlink::read_whole(const std::string &file) {
    struct stat found = {};
    if (::stat(file.c_str(), &found) != 0)
        return;
    const Whole now = {found.st_size, found.st_mtim.tv_sec, found.st_mtim.tv_nsec, false};
    Whole &known = whole_[file];
    if (std::tie(known.size, known.seconds, known.ns) != std::tie(now.size, now.seconds, now.ns))
        known = now;
    else if (!std::exchange(known.is_read, true))
        read_input(file);
}

// Batches, FITS files, and side files of pairs of an input that is followed. Reports once that it cannot be opened, and
// that it is there again.
std::vector<std::string> Downlink::files_in(const std::string &input) {
    std::vector<std::string> files;
    const std::string why = complaint_of(input, [&] {
        if (is_batch(input) && !exists(input))
            malformed(input, std::strerror(ENOENT));
        if (!is_pair(input) && !is_batch(input))
            files = files_of(input);
        else if (is_pair(input) && growing_[side_of(input)].source)
            check_complete(side_of(input));
    });
    if ((is_pair(input) || is_batch(input)) && why.empty())
        files = {is_pair(input) ? side_of(input) : input};
    if (!why.empty() && gone_.insert(input).second)
        sink_.report(Severity::damage, kUnreadable, input, "has disappeared, waiting for it: " + why);
    if (why.empty() && gone_.erase(input) > 0)
        sink_.report(Severity::note, "back", input, "is there again");
    return files;
}

void Downlink::follow() {
    try {
        for (;;) {
            for (const std::string &input : options_.inputs)
                for (const std::string &file : files_in(input))
                    is_pair(file) ? read_growing(file) : read_whole(file);
            sink_.wait();
            ::poll(nullptr, 0, kPollMs); // a signal ends it
            sink_.wait();
        }
    } catch (const Failure &) {
        stopped_ = true;
        conclude();
        throw;
    }
}

// Reports what never arrived, of pairs that were read to their end: others may still grow. So may a pair of which only
// one check found only one file.
void Downlink::conclude() {
    for (auto &[side, pair] : growing_) {
        const bool is_half = !pair.source && pair.halves >= 2 && exists(side) != exists(other_file(side));
        const std::string why = is_half ? complaint_of(side, [side = side] { check_complete(side); }) : "";
        if (!why.empty())
            sink_.report(Severity::damage, kUnreadable, side, why);
        if (!pair.source || !pair.at_end)
            continue;
        try {
            pair.source->finish();
            drain(pair.source);
        } catch (const Failure &) { // files that have disappeared meanwhile are not judged
        }
    }
}

} // namespace cli
