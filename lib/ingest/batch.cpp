// Method: frame k is the reference, which is frame 0, plus the sum of the first k differences, in integers. Files of
// the older writer have the differences from frame 0 instead, under other names. A pixel outside the range of the
// reference shows a damaged file: each frame after it would be wrong.
// The counter of a session runs on from batch to batch, and the name has the number of the batch: b batches before it
// have b times batch_size frames. If a batch begins with a lower id, the camera has restarted before it. Its frames
// then have a number of restarts that no other batch has, 256 b, plus the restarts within it.
#include "ingest/batch.hpp"

#include <algorithm>
#include <charconv>

#include "backend/file.hpp"
#include "base/error.hpp"
#include "base/name.hpp"
#include "base/text.hpp"
#include "ingest/clock_checks.hpp"
#include "ingest/restarts.hpp"

namespace toliman::ingest {

namespace {

constexpr std::string_view kSuffix = ".nc";
constexpr size_t kMostPixels = size_t{1} << 25, kLongestBatch = 65536;
constexpr int64_t kRestartsPerBatch = 256, kHalfCore = 64;
constexpr const char *kRegion = "centre";

// The number in X_batch0007.nc; 0 for other names.
int64_t number_of_batch(const std::string &path) {
    constexpr std::string_view kMark = "_batch";
    const size_t at = path.rfind(kMark);
    int64_t number = 0;
    const char *const digits = path.c_str() + at + kMark.size(), *const end =
                                                                     path.c_str() + path.size() - kSuffix.size();
    const bool is_numbered = at != std::string::npos && std::from_chars(digits, end, number).ptr == end;
    constexpr int64_t kMost = int64_t{1} << 22; // so that restarts are at most 2^31
    return is_numbered && number >= 0 && number <= kMost ? number : 0;
}

// The file's name without folder and suffix.
std::string name_of(const std::string &path) {
    const std::string name = path.substr(path.rfind('/') + 1);
    return name.substr(0, name.size() - kSuffix.size());
}

} // namespace

bool is_batch(const std::string &path) noexcept {
    return path.size() > kSuffix.size() && path.compare(path.size() - kSuffix.size(), kSuffix.size(), kSuffix) == 0;
}

Batch::Batch(const std::string &path, const ReaderOptions &options)
    : Reader(options), path_(path), file_(std::make_unique<netcdf::File>(path)), bytes_(file::stamp(path).size),
      slots_(options.buffers) {
    find_kind();
    if (is_successive_)
        read_numbers();
    else
        read_attributes();
    count_restarts();
}

void Batch::find_kind() {
    is_successive_ = file_->has("centre_reference");
    reference_ = is_successive_ ? "centre_reference" : "ref_core";
    differences_ = is_successive_ ? "centre_differences" : "diff_core";
    if (!file_->has(reference_))
        fail(Status::format, "{%s}: is not a batch of frames: there is no variable centre_reference or ref_core",
             path_.c_str());
    const std::vector<size_t> shape = file_->shape(reference_, true);
    if (shape.size() != 2 || shape[0] < 1 || shape[1] < 1 || shape[0] > kLargestSide || shape[1] > kLargestSide ||
        shape[0] * shape[1] > kMostPixels)
        fail(Status::format, "{%s}: %s: must have 2 dimensions, rows and columns, and at most %zu pixels",
             path_.c_str(), reference_, kMostPixels);
    rows_ = shape[0];
    cols_ = shape[1];
    size_t frames = 1;
    if (file_->has(differences_)) {
        const std::vector<size_t> changes = file_->shape(differences_, true);
        if (changes.size() != 3 || changes[1] != rows_ || changes[2] != cols_ || changes[0] >= kLongestBatch)
            fail(Status::format, "{%s}: %s: must have 3 dimensions, at most %zu frames of %zux%zu as %s", path_.c_str(),
                 differences_, kLongestBatch - 1, rows_, cols_, reference_);
        frames += changes[0];
    }
    lines_.resize(frames);
    const double most = file_->number("valid_max", reference_).value_or(UINT16_MAX);
    most_ = most >= 0 && most < UINT16_MAX ? static_cast<int32_t>(most) : UINT16_MAX;
}

template <class Number> std::vector<Number> Batch::column(const char *name) const {
    const std::vector<size_t> shape = file_->shape(name, std::is_integral_v<Number>);
    if (shape.size() != 1 || shape[0] != lines_.size())
        fail(Status::format, "{%s}: %s: must have %zu numbers, one per frame", path_.c_str(), name, lines_.size());
    std::vector<Number> numbers(lines_.size());
    const size_t start = 0;
    file_->read(name, &start, shape.data(), numbers.data());
    return numbers;
}

void Batch::read_numbers() {
    const std::optional<std::string> session = file_->text("session_id");
    if (!session || !is_name(*session))
        fail(Status::format, "{%s}: session_id = \"%.64s\": %s", path_.c_str(), session.value_or("").c_str(),
             kNameRule);
    const char *const name = names_.insert(*session).first->c_str();
    const std::vector<int64_t> ids = column<int64_t>("frame_id"), stamps = column<int64_t>("timestamp_ns"),
                               dropped = column<int64_t>("nframes_dropped");
    const std::vector<double> host = column<double>("host_time");
    for (size_t k = 0; k < lines_.size(); k++) {
        SideLine &line = lines_[k];
        line.session = name;
        line.frame_id = ids[k];
        line.stamp_ns = stamps[k];
        line.host_s = host[k];
        line.dropped = dropped[k];
    }
}

// The older writer has the keys of each frame as attributes, with its index before them: 0_SEQNUM.
void Batch::read_attributes() {
    const std::string session = name_of(path_);
    if (!is_name(session))
        fail(Status::format, "{%s}: its name is the session: %s", path_.c_str(), kNameRule);
    const char *const name = names_.insert(session).first->c_str();
    for (size_t k = 0; k < lines_.size(); k++) {
        const auto integer = [&](const char *key) {
            const std::string attribute = std::to_string(k) + "_" + key;
            const std::optional<double> number = file_->number(attribute);
            const std::string text = file_->text(attribute).value_or(number ? formatted("%.0f", *number) : "");
            int64_t value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (error != std::errc() || end != text.data() + text.size())
                fail(Status::format, "{%s}: attribute %s = \"%.40s\": must be an integer", path_.c_str(),
                     attribute.c_str(), text.c_str());
            return value;
        };
        lines_[k].session = name;
        lines_[k].frame_id = integer("SEQNUM");
        lines_[k].stamp_ns = integer("CAMTIME");
        if (file_->number(std::to_string(k) + "_CENTR_X")) { // as of FITS files
            lines_[k].window_col = integer("XOFF") + integer("CENTR_X") - kHalfCore;
            lines_[k].window_row = integer("YOFF") + integer("CENTR_Y") - kHalfCore;
        }
    }
}

void Batch::count_restarts() {
    const int64_t batch = number_of_batch(path_);
    const double size = file_->number("batch_size").value_or(0);
    const bool is_restarted =
        is_successive_ && batch > 0 && static_cast<double>(lines_[0].frame_id) < static_cast<double>(batch) * size;
    Restarts restarts;
    ClockChecks clock;
    const char *const region = names_.insert(kRegion).first->c_str();
    for (SideLine &line : lines_) {
        line.roi = region;
        line.has_key = true;
        line.rows = static_cast<uint32_t>(rows_);
        line.cols = static_cast<uint32_t>(cols_);
        if (is_successive_) // the others have no clock of the host
            restarts.count(line, clock.usual_step_ns());
        clock.count(line);
        if (is_restarted || line.restarts > 0)
            line.restarts += kRestartsPerBatch * batch;
        int64_t middle = 0;
        if (line.dropped < 0 || __builtin_add_overflow(line.stamp_ns, line.clock_shift_ns, &middle) ||
            __builtin_add_overflow(middle, shift_of(line, options_), &middle))
            fail(Status::format, "{%s}: frame %lld: nframes_dropped = %lld, timestamp_ns = %lld: impossible",
                 path_.c_str(), static_cast<long long>(line.frame_id), static_cast<long long>(line.dropped),
                 static_cast<long long>(line.stamp_ns));
    }
    lines_[0].is_restart = is_restarted;
}

// Reads all frames up to this one: each is the one before it and a difference.
void Batch::read_pixels(size_t frame) {
    const size_t whole[] = {rows_, cols_}, origin[] = {0, 0}, one[] = {1, rows_, cols_};
    if (pixels_.empty())
        pixels_.resize(rows_ * cols_);
    if (!is_successive_ || read_ == 0)
        file_->read(reference_, origin, whole, pixels_.data());
    change_.resize(pixels_.size());
    const size_t first = is_successive_ ? std::max<size_t>(read_, 1) : std::max<size_t>(frame, 1);
    for (size_t k = first; k <= frame; k++) {
        const size_t start[] = {k - 1, 0, 0};
        file_->read(differences_, start, one, change_.data());
        for (size_t i = 0; i < pixels_.size(); i++) {
            const int64_t sum = int64_t{pixels_[i]} + change_[i];
            pixels_[i] = static_cast<int32_t>(std::clamp<int64_t>(sum, -1, int64_t{most_} + 1));
        }
    }
    read_ = frame + 1;
    const auto bad =
        std::find_if(pixels_.begin(), pixels_.end(), [this](int32_t pixel) { return pixel < 0 || pixel > most_; });
    if (bad == pixels_.end())
        return;
    const size_t at = static_cast<size_t>(bad - pixels_.begin());
    fail(Status::format,
         "{%s}: frame %lld: the differences are damaged: the pixel in row %zu, column %zu is not from 0 "
         "to %d",
         path_.c_str(), static_cast<long long>(lines_[frame].frame_id), at / cols_, at % cols_, most_);
}

Event Batch::frame_event(Slot &slot) {
    read_pixels(next_);
    slot.pixels.resize(pixels_.size());
    std::transform(pixels_.begin(), pixels_.end(), slot.pixels.begin(),
                   [](int32_t pixel) { return static_cast<uint16_t>(pixel); });
    Event event;
    event.kind = EventKind::frame;
    event.line = lines_[next_];
    event.pixels = slot.pixels.data();
    event.number = static_cast<int64_t>(++next_);
    is_warned_ = false;
    counts_.frames++;
    return event;
}

Event Batch::warning(Slot &slot) {
    slot.text = next_ == 0 ? "the camera has restarted in an earlier batch: its times are those of the clock since then"
                           : "the camera has restarted: frames are counted from " +
                                 std::to_string(lines_[next_].frame_id) + " again";
    Event event;
    event.kind = EventKind::warning;
    event.reason = Reason::restart;
    event.text = slot.text.c_str();
    event.number = static_cast<int64_t>(next_) + 1;
    is_warned_ = true;
    counts_.warnings++;
    return event;
}

// A restart gives two events: the warning, then, in the next call, its frame. Each event has the next of the slots, so
// that its pixels and texts stay valid during the next calls.
Event Batch::next() {
    Event event;
    slot_ = (slot_ + 1) % slots_.size();
    for (; file_ && next_ < lines_.size() && !is_wanted(lines_[next_]); next_++)
        counts_.skipped++;
    if (file_ && next_ < lines_.size())
        event = lines_[next_].is_restart && !is_warned_ ? warning(slots_[slot_]) : frame_event(slots_[slot_]);
    else
        file_.reset();
    event.file = &path_;
    return event;
}

ReaderCounts Batch::counts() const noexcept {
    ReaderCounts counts = counts_;
    counts.lines = static_cast<int64_t>(next_);
    counts.bytes = bytes_;
    return counts;
}

} // namespace toliman::ingest
