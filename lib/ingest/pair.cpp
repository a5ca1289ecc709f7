// Method: an examination of the files reads the new lines and finds out which of them have pixels in the file
// (placement.cpp); the following calls report these lines one by one. Both files are written independently, so that one
// may be ahead of the other at any time. Lines without pixels, and pixels without line, are therefore damage only at
// the end. The pixel type is that of the key dtype of the lines. Without it, it is u16le, as the mission writes, or
// u32le if complete files have at least 1.5 times these bytes, half way between. Where growing files look replaced, or
// like those of another pixel type, a second examination decides: the first may have seen one file of before and one
// of after.
#include "ingest/pair.hpp"

#include <algorithm>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"
#include "ingest/realign.hpp"

namespace toliman::ingest {

namespace {

constexpr const char kSide[] = "_meta.jsonl", kPixels[] = "_frames.bin";
// A valid line has more bytes than this. A file with far more lines cannot be a side file, and would take more memory
// than it has bytes.
constexpr uint64_t kShortestLine = 120;
constexpr int64_t kMoreLines = 1024;

std::string stem_of(const std::string &path) {
    for (const std::string end : {kSide, kPixels})
        if (path.size() >= end.size() && path.compare(path.size() - end.size(), end.size(), end) == 0)
            return path.substr(0, path.size() - end.size());
    return path;
}

const char *type_name(size_t pixel_bytes) noexcept {
    return pixel_bytes == 4 ? "u32le" : "u16le";
}

std::string restart_text(const SideLine &line) {
    const std::string clock =
        line.clock_shift_ns == 0
            ? "its clock has continued"
            : formatted("%g s are added to timestamp_ns from here on, so that it continues as host_time does",
                        static_cast<double>(line.clock_shift_ns) / 1e9);
    return formatted("the camera has restarted: frames are counted from %lld again; %s",
                     static_cast<long long>(line.frame_id), clock.c_str());
}

} // namespace

Pair::Pair(const std::string &path, const ReaderOptions &options)
    : Reader(options), side_path_(stem_of(path) + kSide), pixel_path_(stem_of(path) + kPixels), slots_(options.buffers),
      pixel_bytes_(options.pixel_bytes), placement_(options.rows, options.cols) {
    [[maybe_unused]] const file::Reader side(side_path_), pixels(pixel_path_); // fail if a file cannot be opened
}

ReaderCounts Pair::counts() const noexcept {
    ReaderCounts counts = counts_;
    counts.lines = placement_.counted();
    counts.bytes = pixel_stamp_.size;
    return counts;
}

// Forgets the lines of files that were replaced. Counts of events stay.
void Pair::restart() noexcept {
    side_ = {};
    forget_lines();
    pixel_bytes_ = options_.pixel_bytes;
    is_type_written_ = false;
    placement_ = {options_.rows, options_.cols};
    clock_ = {};
    restarts_ = {};
    warnings_.clear();
    is_judged_ = false;
}

void Pair::add_line(const std::string &text, int64_t number, int64_t most) {
    if (placement_.counted() == most)
        fail(Status::format, "{%s}: has more than %lld lines in %llu bytes: a frame takes %llu bytes",
             side_path_.c_str(), static_cast<long long>(most), static_cast<unsigned long long>(side_stamp_.size),
             static_cast<unsigned long long>(kShortestLine));
    SideLine line = parse_side_line(text, options_.exposure_s, names_);
    line.number = number;
    if (line.error.empty())
        use_type(line);
    if (line.error.empty())
        restarts_.count(line, clock_.usual_step_ns());
    int64_t middle = 0;
    if (line.error.empty() && (__builtin_add_overflow(line.stamp_ns, line.clock_shift_ns, &middle) ||
                               __builtin_add_overflow(middle, shift_of(line, options_), &middle)))
        line.error = "timestamp_ns: the middle of the exposure exceeds 64 bits";
    lines_.push_back(std::move(line));
    try {
        clock_.count(lines_.back());
    } catch (...) { // out of memory: the line is given again
        lines_.pop_back();
        throw;
    }
    placement_.count(lines_.back());
}

void Pair::read_lines(const file::Reader &side) {
    if (first_ > lines_.size() / 2) { // amortised: each line is moved once
        lines_.erase(lines_.begin(), lines_.begin() + static_cast<std::ptrdiff_t>(first_));
        first_ = 0;
    }
    const int64_t most = kMoreLines + static_cast<int64_t>(side_stamp_.size / kShortestLine);
    side_.read(side, side_stamp_.size, !options_.growing,
               [&](const std::string &text, int64_t number) { add_line(text, number, most); });
}

// Takes the pixel type that a line names.
void Pair::use_type(SideLine &line) {
    if (line.pixel_bytes == 0)
        return;
    if (pixel_bytes_ == 0)
        pixel_bytes_ = line.pixel_bytes;
    const char *const here = type_name(line.pixel_bytes), *const known = type_name(pixel_bytes_);
    if (line.pixel_bytes != pixel_bytes_ && options_.pixel_bytes != 0 && !is_type_written_)
        fail(Status::format, "{%s}: dtype is %s in line %lld, but %s was given (--dtype)", side_path_.c_str(), here,
             static_cast<long long>(line.number), known);
    if (line.pixel_bytes != pixel_bytes_)
        line.error = formatted("dtype must be %s, as before, not %s", known, here);
    is_type_written_ = true;
}

// Decides on the pixel type if no line names it.
void Pair::find_type() {
    if (pixel_bytes_ == 0 && placement_.has_valid())
        pixel_bytes_ = !options_.growing && pixel_stamp_.size / 3 >= placement_.pixels() ? 4 : 2;
    placement_.set_pixel_bytes(pixel_bytes_);
}

// Compares the size of the file with that of the frames as the other pixel type, unless a line names the type. Only
// before the first frame: later on the files may pass through such sizes.
void Pair::check_type(bool certain) {
    const uint64_t bytes = placement_.bytes(), size = pixel_stamp_.size;
    const bool is_wide = pixel_bytes_ == 4;
    if (is_type_written_ || placement_.released() > 0 || bytes == 0 ||
        (is_wide ? bytes != 2 * size : 2 * bytes != size))
        return;
    is_other_type_ = true;
    const char *const other = type_name(is_wide ? 2 : 4);
    if (certain)
        fail(Status::format, "{%s}: has %llu bytes, %s those of %lld frames of %s: are its pixels %s (--dtype %s)?",
             pixel_path_.c_str(), static_cast<unsigned long long>(size), is_wide ? "half" : "twice",
             static_cast<long long>(placement_.counted()), type_name(pixel_bytes_), other, other);
}

// Reads the new lines. Settled, and without a new line, if the files have not changed.
void Pair::look() {
    const file::Stamp side_now = file::stamp(side_path_), pixels_now = file::stamp(pixel_path_);
    rests_ = side_now == side_stamp_ && pixels_now == pixel_stamp_;
    if (rests_ && is_settled_)
        return;
    is_settled_ = false;
    const file::Reader side(side_path_);
    pixels_.emplace(pixel_path_);
    const file::Stamp side_stamp = side.stamp(), pixel_stamp = pixels_->stamp();
    const bool is_replaced = side_stamp_.was_replaced(side_stamp) || pixel_stamp_.was_replaced(pixel_stamp);
    side_stamp_ = side_stamp;
    pixel_stamp_ = pixel_stamp;
    const bool is_second = std::exchange(is_other_type_, false);
    if (is_replaced)
        restart();
    if (is_replaced && options_.growing)
        return;
    read_lines(side);
    find_type();
    check_type(is_second || !options_.growing);
    placement_.set_size(pixel_stamp_.size);
    is_settled_ = !is_other_type_;
}

Event Pair::report(Slot &slot, EventKind kind, Reason reason, std::string text) {
    slot.text = std::move(text);
    (kind == EventKind::damage ? counts_.damaged : counts_.warnings)++;
    Event event;
    event.kind = kind;
    event.reason = reason;
    event.file = &side_path_;
    event.number = front_number();
    event.text = slot.text.c_str();
    return event;
}

// Reports the first line as damaged.
Event Pair::damage(Slot &slot, Reason reason, std::string text) {
    Event event = report(slot, EventKind::damage, reason, std::move(text));
    const SideLine &line = front();
    event.line.has_key = line.has_key;
    if (reason != Reason::bad_line) {
        event.line = line;
    } else if (line.has_key) {
        event.line.session = line.session;
        event.line.roi = line.roi;
        event.line.frame_id = line.frame_id;
    }
    release();
    return event;
}

Event Pair::frame(Slot &slot, const Place &place) {
    slot.pixels.resize(static_cast<size_t>(place.bytes));
    is_settled_ = false; // if the file was truncated meanwhile
    pixels_->read_exactly(place.offset + static_cast<uint64_t>(placement_.shift()), slot.pixels.data(),
                          slot.pixels.size());
    is_settled_ = true;
    Event event;
    event.kind = EventKind::frame;
    event.file = &side_path_;
    event.number = front_number();
    event.line = front();
    slot.on_target_s = event.line.on_target_s;
    slot.spread = event.line.spread;
    event.pixels = slot.pixels.data();
    event.offset = place.offset;
    counts_.frames++;
    calls_since_frame_ = 0;
    clock_.pass(front(), front_number());
    release();
    return event;
}

void Pair::release() {
    placement_.release(front());
    front() = {};
    first_++;
    warnings_.clear();
    is_judged_ = false;
    if (is_empty())
        forget_lines();
}

void Pair::skip() {
    counts_.skipped++;
    if (front().error.empty())
        clock_.pass(front(), front_number());
    release();
}

std::optional<Event> Pair::give_placed(Slot &slot, const Place &place) {
    const SideLine &line = front();
    if (!is_wanted(line)) {
        skip();
        return std::nullopt;
    }
    if (!line.error.empty())
        return damage(slot, Reason::bad_line, line.error);
    if (placement_.bytes(line) != place.bytes)
        return damage(slot, Reason::bad_line,
                      formatted("n_rows = %u, n_cols = %u: the frames in %s have another shape", line.rows, line.cols,
                                pixel_path_.c_str()));
    judge(line);
    if (warnings_.empty())
        return frame(slot, place);
    const auto &[reason, text] = warnings_.front();
    const Event event = report(slot, EventKind::warning, reason, text);
    warnings_.pop_front();
    return event;
}

// Finds the warnings of the first line, whose frame is valid, once; all or, without memory, none.
void Pair::judge(const SideLine &line) {
    if (is_judged_)
        return;
    std::deque<std::pair<Reason, std::string>> found;
    unsigned told = told_;
    const auto warn = [&](Reason reason, std::string text, bool each_time = false) {
        const unsigned bit = 1u << static_cast<unsigned>(reason);
        if (text.empty() || ((told & bit) != 0 && !each_time))
            return false;
        found.emplace_back(reason, std::move(text));
        told |= bit;
        return true;
    };
    if (line.unknown_key != nullptr)
        warn(Reason::unknown_key, formatted("unknown key \"%s\": ignored, in all lines", line.unknown_key));
    if (line.is_restart)
        warn(Reason::restart, restart_text(line), true);
    if (!warn(Reason::clock_jump, clock_.jump(line, front_number()), true) &&
        !warn(Reason::clocks_differ, clock_.drift(line)))
        warn(Reason::overlap, clock_.overlap(line, exposure_of(line, options_)));
    warnings_.swap(found);
    told_ = told;
    is_judged_ = true;
}

// Decides at the end of the files whether lines without pixels and pixels without line are damage.
void Pair::begin_rest() {
    if (is_over_ || !(options_.growing ? is_finished_ : is_settled_))
        return;
    const bool may_grow = options_.growing && !(is_settled_ && rests_ && file::is_unchanged(side_path_, side_stamp_) &&
                                                file::is_unchanged(pixel_path_, pixel_stamp_));
    is_over_ = true;
    if (may_grow)
        forget_lines();
    else if (is_empty())
        extra_bytes_ = placement_.extra_bytes();
    else
        rest_reason_ = placement_.has_odd() || placement_.is_odd(front()) ? Reason::place_unknown : Reason::short_file;
}

std::optional<Event> Pair::give_rest(Slot &slot) {
    for (; !is_empty(); skip()) {
        if (!is_wanted(front()))
            continue;
        if (!front().error.empty())
            return damage(slot, Reason::bad_line, front().error);
        const bool is_short = rest_reason_ == Reason::short_file;
        return damage(slot, rest_reason_,
                      formatted(is_short ? "%s ends before this frame"
                                         : "the position of the frame in %s is unknown: this or an earlier line is "
                                           "malformed or has another shape",
                                pixel_path_.c_str()));
    }
    if (extra_bytes_ == 0)
        return std::nullopt;
    Event event =
        report(slot, EventKind::warning, Reason::extra_bytes,
               formatted("has %llu bytes more than the frames of %s",
                         static_cast<unsigned long long>(std::exchange(extra_bytes_, 0)), side_path_.c_str()));
    event.file = &pixel_path_;
    event.number = 0;
    return event;
}

std::optional<Event> Pair::give(Slot &slot) {
    while (is_settled_ && !is_empty()) {
        const std::optional<Place> place = placement_.next(front());
        if (!place)
            break;
        if (std::optional<Event> event = give_placed(slot, *place))
            return event;
    }
    begin_rest();
    return is_over_ ? give_rest(slot) : std::nullopt;
}

// The surplus of the file tells the sign of the shift. A frame of which a part is lost is therefore not taken for the
// next one, which is where it should be but for the surplus.
int64_t Pair::find(uint64_t offset, size_t pixels, const void *reference, void *found) const {
    const int64_t surplus = placement_.surplus(), now = placement_.shift(), place = static_cast<int64_t>(offset);
    const auto frame = static_cast<int64_t>(pixels * pixel_bytes_);
    const int64_t least = std::max(std::min<int64_t>(surplus, 0), now - frame + 1),
                  most = std::min(std::max<int64_t>(surplus, 0), now + frame - 1);
    if (options_.growing || surplus == 0)
        return 0;
    const file::Reader file(pixel_path_);
    const std::optional<int64_t> at = find_frame(file, {place + least, place + most, pixels, pixel_bytes_}, reference);
    if (!at || *at == place)
        return 0;
    file.read_exactly(static_cast<uint64_t>(*at), found, static_cast<size_t>(frame));
    return *at - place;
}

Event Pair::next() {
    const bool is_first = side_stamp_.inode == 0;
    const bool may_grow = options_.growing ? !is_finished_ : !is_settled_;
    if (is_idle_ && !is_over_ && (is_first || may_grow))
        look();
    slot_ = (slot_ + 1) % slots_.size();
    calls_since_frame_++;
    is_idle_ = true; // also if what follows fails
    std::optional<Event> event = give(slots_[slot_]);
    if (event) {
        is_idle_ = false;
        return *event;
    }
    pixels_.reset();
    if (calls_since_frame_ >= slots_.size()) // nobody uses them: thousands of pairs may be followed
        for (Slot &slot : slots_)            // "= {}" would keep the memory
            Buffer<uint8_t>(slot.pixels.get_allocator()).swap(slot.pixels);
    Event nothing;
    nothing.file = &side_path_;
    return nothing;
}

} // namespace toliman::ingest
