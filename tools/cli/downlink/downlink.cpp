#include "downlink/downlink.hpp"

#include <fstream>
#include <poll.h>
#include <sys/stat.h>

#include "base/name.hpp"
#include "common/lines.hpp"
#include "frames/frames_in.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

// The file's name without folder and suffix.
std::string name_of(const std::string &path) {
    std::string name = path.substr(path.rfind('/') + 1);
    for (const char *suffix : {".npy", ".fits", ".fits.fz", ".fits.gz"})
        if (ends_with(name, suffix))
            return name.substr(0, name.size() - std::strlen(suffix));
    return name;
}

// event.line is the index of the frame in the file, from 0.
class DatedFile : public FrameSource {
  public:
    // first_id: of the first frame. Frames with other ids than the wanted ones are skipped.
    DatedFile(std::unique_ptr<FrameFile> file, size_t buffers, const std::string &session, int64_t first_id,
              const FrameTimes &times, const FrameIds &wanted)
        : file_(std::move(file)), buffers_(std::min(buffers, file_->count())), session_(session), first_id_(first_id),
          times_(times), wanted_(wanted) {}
    int64_t skipped() const override { return skipped_; }

    bool next(toliman_frame &frame, toliman_ingest_event &event) override {
        for (; file_->more(); skipped_++, file_->skip()) {
            const size_t k = frame_++;
            frame = toliman::sized<toliman_frame>();
            frame.frame_id = first_id_ + static_cast<int64_t>(k);
            if (!wanted_.contains(frame.frame_id))
                continue;
            std::vector<double> &pixels = buffers_[next_++ % buffers_.size()];
            pixels.resize((file_->frame_size() + sizeof(double) - 1) / sizeof(double));
            file_->read(pixels.data());
            frame.session = session_.c_str();
            frame.roi = "single_roi"; // the mission's name of the only region
            frame.camera_ns = times_.at(k);
            frame.exposure_s = times_.exposure_s();
            const FrameWindow window = file_->window(k).value_or(FrameWindow());
            frame.window_row = window[0];
            frame.window_col = window[1];
            frame.pixel = file_->pixel();
            frame.pixels = pixels.data();
            frame.rows = static_cast<int64_t>(file_->rows());
            frame.cols = static_cast<int64_t>(file_->cols());
            event = toliman::sized<toliman_ingest_event>();
            event.event = TOLIMAN_INGEST_EVENT_FRAME;
            event.reason = TOLIMAN_INGEST_REASON_NONE;
            event.has_key = 1;
            event.file = file_->path().c_str();
            event.line = static_cast<int64_t>(k);
            event.text = "";
            return true;
        }
        return false;
    }

  private:
    std::unique_ptr<FrameFile> file_;
    std::vector<std::vector<double>> buffers_; // of doubles, which are aligned for every type
    std::string session_;
    int64_t first_id_, skipped_ = 0;
    FrameTimes times_;
    FrameIds wanted_;
    size_t next_ = 0, frame_ = 0; // buffer and frame that come next
};

constexpr int kPollMs = 1000;
constexpr const char kUnreadable[] = "unreadable input";
constexpr const char kInputs[] = "must be X_frames.bin, X_meta.jsonl, .nc, .npy, .fits, .fits.fz, .fits.gz or a folder";
constexpr const char kNeedsDtype[] =
    "a new folder needs --dtype u16le or u32le, or --bit-depth, for raw pairs that are named on standard input";

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

// The spread of a line of a side file, without cumulants; nothing for a single frame and a damaged line.
std::optional<toliman_spread> spread_of(const std::string &line) {
    const JsonTree tree(cJSON_Parse(line.c_str()));
    const cJSON *const frames = cJSON_GetObjectItemCaseSensitive(tree.get(), "frames"),
                       *const jitter = cJSON_GetObjectItemCaseSensitive(tree.get(), "jitter_px2");
    if (cJSON_IsNumber(frames) == 0 || cJSON_GetArraySize(jitter) != 3)
        return std::nullopt;
    auto spread = toliman::sized<toliman_spread>();
    spread.frames = frames->valuedouble;
    spread.xx_px2 = cJSON_GetArrayItem(jitter, 0)->valuedouble;
    spread.yy_px2 = cJSON_GetArrayItem(jitter, 1)->valuedouble;
    spread.xy_px2 = cJSON_GetArrayItem(jitter, 2)->valuedouble;
    return spread;
}

} // namespace

// Files of one session are distinguished by their key FRAME1 or SEQNUM, never by the order in which they arrive.
DatedFiles::Span DatedFiles::span_of(FrameFile &file) {
    const std::string &path = file.path(), &given = options_.session, session = given.empty() ? name_of(path) : given;
    const std::optional<int64_t> number = file.first_id();
    if (!toliman::is_name(session))
        malformed(path,
                  "session " + session + ": must have 1 to 64 characters A-Z a-z 0-9 . _ - and not begin with a dot");
    if (!given.empty() && !number) {
        if (!unnumbered_.empty() && unnumbered_ != path)
            malformed(path, "has no key FRAME1 or SEQNUM, the number of its first frame: --session " + session +
                                " cannot distinguish it from " + unnumbered_);
        unnumbered_ = path;
    }
    const int64_t first_id = number.value_or(0);
    return {path, session, first_id, first_id + static_cast<int64_t>(file.count()) - 1};
}

FrameTimes DatedFiles::times_of(FrameFile &file, const Span &span) {
    const int64_t time_zero_ns = options_.begins_at_epoch ? sink_.settings().grid.time_offset_ns : 0;
    FrameTimes times(file, span.first_id, options_.cadence, options_.leap_seconds, time_zero_ns);
    const std::string &path = file.path();
    if (times.is_tai() && sink_.settings().clock.count > 0)
        throw Failure(kExitUsage,
                      path + ": its time (" + times.rule() +
                          ") is TAI, but the state folder has a clock table: give a folder without --clock");
    if (is_fits(path))
        sink_.report(times.is_assumed() ? Severity::warning : Severity::note, "time", path, "time by " + times.rule());
    if (times.by_cadence())
        warn_of_overlap(span, times);
    return times;
}

// The same frames again have the same times.
void DatedFiles::warn_of_overlap(Span span, const FrameTimes &times) {
    span.first_ns = times.at(0);
    span.last_ns = times.at(static_cast<size_t>(span.last_id - span.first_id));
    const auto has_frames = [&span](const Span &other) {
        return span.session == other.session && span.first_id <= other.last_id && other.first_id <= span.last_id;
    };
    const auto overlaps = [&span](const Span &other) {
        return span.first_ns <= other.last_ns && other.first_ns <= span.last_ns;
    };
    if (std::any_of(spans_.begin(), spans_.end(), has_frames))
        return;
    const auto other = std::find_if(spans_.begin(), spans_.end(), overlaps);
    if (other != spans_.end())
        sink_.report(Severity::warning, "same times", span.path,
                     "its times by --cadence overlap those of " + other->path +
                         ": FRAME1 or a time in the header of a FITS file distinguishes them");
    spans_.push_back(span);
}

std::shared_ptr<FrameSource> DatedFiles::open(const std::string &path, const FrameIds &wanted) {
    auto file = open_frames(path, "", 0, 0, options_.unit);
    for (const std::string &note : file->notes())
        sink_.report(Severity::warning, "other images", path, note);
    const Span span = span_of(*file);
    const FrameTimes times = times_of(*file, span);
    return std::make_shared<DatedFile>(std::move(file), sink_.batch(), span.session, span.first_id, times, wanted);
}

void InputOptions::add_to(CLI::App &command) {
    add_choice(&command, "--dtype", dtype, {"u16le", "u32le"});
    add_option(&command, "--roi", roi, "LABEL");
    command.add_option("--cadence", dated.cadence)->check(CLI::PositiveNumber);
    add_option(&command, "--hdu", dated.unit, "NAME");
    command.add_flag("--follow", follow);
    add_option(&command, "INPUT", inputs, "")->required();
}

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
        if (is_pair(input) && !options.follow)
            check_complete(side_of(input));
    }
    if (options.roi.empty())
        check_one_region(options.inputs);
}

int32_t first_pixel(const InputOptions &options) {
    auto reading = toliman::sized<toliman_ingest_options>();
    reading.flags = options.follow ? TOLIMAN_INGEST_GROWING : 0;
    toliman_frame frame;
    toliman_ingest_event event;
    int32_t found = 0;
    for (const std::string &input : options.inputs)
        for (const std::string &file : files_in(input)) {
            if (found != 0 || !is_pair(file) || !exists(file) || !exists(other_file(file)))
                continue;
            complaint_of(file, [&] { // is reported when its frames are read
                PairSource pair(file, reading);
                pair.next(frame, event);
                found = pair.pixel();
            });
        }
    return found;
}

KnownSums::KnownSums(const std::vector<std::string> &inputs) {
    for (const std::string &input : inputs) {
        for (const std::string &file : files_in(input)) {
            if (!is_pair(file)) {
                waits = false;
                continue;
            }
            std::ifstream lines(side_of(file));
            for (std::string line; std::getline(lines, line) && !lines.eof();) { // the last one may be cut
                if (line.find_first_not_of(" \r\t") == std::string::npos)
                    continue;
                waits = false;
                const std::optional<toliman_spread> spread = spread_of(line);
                if (!spread)
                    break;
                if (!largest || largest->frames < spread->frames)
                    largest = spread;
            }
        }
    }
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
    if (options_.needs_dtype)
        malformed(path, kNeedsDtype);
    check_complete(side_of(path));
    drain(open_pair(path));
}

std::shared_ptr<PairSource> Downlink::open_pair(const std::string &path) const {
    const toliman_track_options &settings = sink_.settings();
    auto options = toliman::sized<toliman_ingest_options>();
    options.flags = options_.follow ? TOLIMAN_INGEST_GROWING : 0;
    options.pixel = pixel_of_pair(path, options_.dtype);
    options.stamp = settings.frames.stamp;
    options.exposure_s = settings.frames.exposure_s;
    options.rows = settings.frames.rows;
    options.cols = settings.frames.cols;
    options.first_id = options_.frames.first;
    options.end_id = options_.frames.end;
    options.buffers = static_cast<uint32_t>(sink_.batch());
    options.roi = options_.roi.empty() ? nullptr : options_.roi.c_str();
    // The type of a pair's pixels may be a guess from the sizes of its files; a batch states what it contains.
    const bool suits = options_.suits_folder && !is_batch(path);
    return std::make_shared<PairSource>(path, options, suits ? settings.frames.bit_depth : 0);
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
