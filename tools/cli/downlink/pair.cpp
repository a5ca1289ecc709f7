#include "downlink/pair.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <toliman/track.h>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr const char kSide[] = "_meta.jsonl", kBinary[] = "_frames.bin";
constexpr double kJump = 1000;      // of the median gap
constexpr double kMostDelay = 1;    // s, of a frame on its way to the host
constexpr double kMostDrift = 0.01; // of one clock against the other

std::string stem_of(const std::string &path) {
    for (const std::string suffix : {kSide, kBinary})
        if (ends_with(path, suffix))
            return path.substr(0, path.size() - suffix.size());
    return path;
}

double gap(const SideLine &before, const SideLine &after) noexcept {
    return static_cast<double>(after.facts.camera_ns) - static_cast<double>(before.facts.camera_ns);
}

} // namespace

bool is_pair(const std::string &path) {
    return ends_with(path, kSide) || ends_with(path, kBinary);
}

std::string side_of(const std::string &path) {
    return stem_of(path) + kSide;
}

std::string binary_of(const std::string &path) {
    return stem_of(path) + kBinary;
}

size_t Pair::usual_bytes() const noexcept {
    return format_.rows * format_.cols * (format_.wide ? 4 : 2);
}

// A line that cannot be read is taken for one of the usual shape.
size_t Pair::bytes(const SideLine &line) const noexcept {
    return line.why.empty() ? line.facts.rows * line.facts.cols * (format_.wide ? 4 : 2) : usual_bytes();
}

// That by which the lines' frames take the binary's size, if it is not the one that was asked for.
std::string Pair::other_dtype() const {
    size_t own = 0;
    for (const SideLine &line : lines_)
        own += bytes(line);
    if (format_.wide)
        return own > 0 && own == 2 * binary_stamp_.size ? "u16le" : "";
    return own > 0 && 2 * own == binary_stamp_.size ? "u32le" : "";
}

// Where the lines' own shapes add up to the binary's size, they tell where each frame is. Else where the usual shape
// does, a line of another one is wrong. Else frames have a place only up to the first line that is bad or of another
// shape than the first: what is behind it may be shifted.
void Pair::place(size_t size) {
    const size_t usual = usual_bytes();
    size_t own = 0;
    for (const SideLine &line : lines_)
        own += bytes(line);
    if (own != size && lines_.size() * usual == size) {
        for (SideLine &line : lines_)
            if (bytes(line) != usual)
                line.why = "its n_rows and n_cols are not those of the frames in " + binary_;
        own = size;
    }
    places_.clear();
    used_ = 0;
    for (const SideLine &line : lines_) {
        const bool odd = !line.why.empty() || bytes(line) != bytes(lines_.front());
        if (own != size && (odd || used_ + bytes(line) > size))
            break;
        places_.push_back({used_, bytes(line)});
        used_ += bytes(line);
    }
}

double Pair::usual_gap() const {
    std::vector<double> gaps;
    for (size_t i = 1; i < lines_.size(); i++)
        if (lines_[i].why.empty() && lines_[i - 1].why.empty())
            gaps.push_back(std::fabs(gap(lines_[i - 1], lines_[i])));
    if (gaps.empty())
        return 0;
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    return *middle;
}

// The line itself where there is none.
size_t Pair::good_before(size_t line) const noexcept {
    for (size_t i = line; i-- > 0;)
        if (lines_[i].why.empty())
            return i;
    return line;
}

// Regions of one exposure share their time and frame id.
bool Pair::stands(size_t before, size_t line) const noexcept {
    const FrameFacts &a = lines_[before].facts, &b = lines_[line].facts;
    return a.camera_ns == b.camera_ns && a.id != b.id && a.session == b.session && a.roi == b.roi;
}

// Empty where the clock goes on.
std::string Pair::jump_at(size_t line, double usual) const {
    const size_t before = good_before(line);
    if (before == line)
        return "";
    const double step = gap(lines_[before], lines_[line]);
    if (step < 0)
        return "the clock goes back by " + std::to_string(-step / 1e9) + " s";
    if (stands(before, line) && !stands(good_before(before), before)) // once a standstill
        return "the clock stands still: " + std::to_string(lines_[line].facts.camera_ns) +
               " ns, as of the frame before";
    if (usual > 0 && step > kJump * usual * static_cast<double>(line - before))
        return "the clock jumps by " + std::to_string(step / 1e9) + " s, the median step is " +
               std::to_string(usual / 1e9) + " s";
    return "";
}

// The camera's clock against the host's, since the first good line; once a file.
void Pair::remark_drift(Receiver &receiver, size_t line) {
    if (drift_told_)
        return;
    const auto first = std::find_if(lines_.begin(), lines_.end(), [](const SideLine &one) { return one.why.empty(); });
    const double camera = gap(*first, lines_[line]) / 1e9, host = lines_[line].host_s - first->host_s;
    if (!(std::fabs(camera - host) > kMostDelay + kMostDrift * std::max(std::fabs(camera), std::fabs(host))))
        return;
    drift_told_ = true;
    receiver.tell("clocks differ", where(line),
                  "since line " + std::to_string(first - lines_.begin() + 1) + " timestamp_ns goes on by " +
                      std::to_string(camera) + " s, host_time by " + std::to_string(host) + " s",
                  true);
}

void Pair::give(Receiver &receiver) {
    InputFile file(binary_);
    const double usual = usual_gap();
    for (; given_ < places_.size(); given_++) {
        const SideLine &line = lines_[given_];
        if (line.why.empty() && !receiver.wants(line.facts))
            continue;
        if (!line.why.empty()) {
            receiver.reject(where(given_), line.named ? &line.facts : nullptr, "bad line", line.why);
            continue;
        }
        const std::string jump = jump_at(given_, usual);
        if (jump.empty())
            remark_drift(receiver, given_);
        else
            receiver.remark(Remark::clock_jump, where(given_), jump);
        Arrival &arrival = receiver.next();
        arrival.pixels.resize(places_[given_].size);
        file.seek(places_[given_].offset);
        file.read_known(arrival.pixels.data(), arrival.pixels.size());
        arrival.where = where(given_);
        arrival.facts = line.facts;
        arrival.pixel = format_.wide ? TOLIMAN_PIXEL_U32 : TOLIMAN_PIXEL_U16;
        receiver.take();
    }
}

// A pair that grows is looked at twice before it is read where its files were replaced, of which one may still be that
// of before, and where its sizes are those of another dtype, which it may be growing through.
void Pair::read(Receiver &receiver, bool growing) {
    const FileStamp side(side_), binary(binary_);
    growing_ = growing;
    rests_ = side == side_stamp_ && binary == binary_stamp_;
    if (growing && !doubtful_ && rests_)
        return;
    const bool replaced = was_replaced(side_stamp_, side) || was_replaced(binary_stamp_, binary);
    const bool looked_at = !growing || std::exchange(doubtful_, replaced);
    side_stamp_ = side;
    binary_stamp_ = binary;
    if (replaced) {
        given_ = 0;
        return;
    }
    lines_ = read_side_file(side_, growing);
    const std::string other = given_ == 0 ? other_dtype() : "";
    if (other.empty()) {
        place(binary.size);
        give(receiver);
    } else if (looked_at) {
        malformed(binary_, "holds " + std::string(format_.wide ? "half" : "2 times") + " the bytes of its " +
                               std::to_string(lines_.size()) + " frames: is it " + other + "?");
    } else {
        doubtful_ = true;
    }
}

// Files that are gone are not what they were.
bool Pair::is_unchanged() const {
    try {
        return FileStamp(side_) == side_stamp_ && FileStamp(binary_) == binary_stamp_;
    } catch (const Failure &) {
        return false;
    }
}

void Pair::end(Receiver &receiver) {
    if (doubtful_ || given_ < places_.size() || (given_ == 0 && !other_dtype().empty()))
        return;
    if (growing_ && !(rests_ && is_unchanged()))
        return;
    const bool behind_odd =
        given_ < lines_.size() && (!lines_[given_].why.empty() || bytes(lines_[given_]) != bytes(lines_.front()));
    for (; given_ < lines_.size(); given_++) {
        const SideLine &line = lines_[given_];
        if (!line.why.empty())
            receiver.reject(where(given_), line.named ? &line.facts : nullptr, "bad line", line.why);
        else if (behind_odd)
            receiver.reject(where(given_), &line.facts, "place unknown",
                            "stands at or behind a line that is bad or of another shape, and the size of " + binary_ +
                                " does not tell where its frame is");
        else
            receiver.reject(where(given_), &line.facts, "short file", binary_ + " ends before this frame");
    }
    if (binary_stamp_.size > used_ && places_.size() == lines_.size())
        receiver.remark(Remark::extra_bytes, binary_,
                        std::to_string(binary_stamp_.size - used_) + " bytes more than the frames of " + side_);
}

} // namespace cli
