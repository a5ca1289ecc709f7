#include "pair.hpp"

#include <algorithm>
#include <cmath>

#include <toliman/track.h>

#include "failure.hpp"
#include "input.hpp"
#include "suffix.hpp"

namespace cli {

namespace {

constexpr const char kSide[] = "_meta.jsonl", kBinary[] = "_frames.bin";
constexpr double kJump = 1000; // of the median gap

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

void Pair::remark_jump(Receiver &receiver, size_t line, double usual) const {
    if (line == 0 || !lines_[line].why.empty() || !lines_[line - 1].why.empty())
        return;
    const double step = gap(lines_[line - 1], lines_[line]);
    if (step < 0)
        receiver.remark(Remark::clock_jump, where(line),
                        "the clock goes back by " + std::to_string(-step / 1e9) + " s");
    else if (usual > 0 && step > kJump * usual)
        receiver.remark(Remark::clock_jump, where(line),
                        "the clock jumps by " + std::to_string(step / 1e9) + " s, the median step is " +
                            std::to_string(usual / 1e9) + " s");
}

void Pair::give(Receiver &receiver) {
    InputFile file(binary_);
    const double usual = usual_gap();
    for (; given_ < places_.size(); given_++) {
        const SideLine &line = lines_[given_];
        if (line.why.empty() && !receiver.wants(line.facts))
            continue;
        remark_jump(receiver, given_, usual);
        if (!line.why.empty()) {
            receiver.reject(where(given_), nullptr, "bad line", line.why);
            continue;
        }
        Arrival &arrival = receiver.next();
        arrival.pixels.resize(places_[given_].size);
        file.seek(places_[given_].offset);
        if (!file.read(arrival.pixels.data(), arrival.pixels.size()))
            malformed(binary_, "cannot be read");
        arrival.where = where(given_);
        arrival.facts = line.facts;
        arrival.pixel = format_.wide ? TOLIMAN_PIXEL_U32 : TOLIMAN_PIXEL_U16;
        receiver.take();
    }
}

void Pair::read(Receiver &receiver, bool growing) {
    const size_t side_size = InputFile(side_).size(), binary_size = InputFile(binary_).size();
    if (growing && side_size == side_size_ && binary_size == binary_size_)
        return;
    if (side_size < side_size_) // others of the same name
        given_ = 0;
    side_size_ = side_size;
    binary_size_ = binary_size;
    lines_ = read_side_file(side_, growing);
    place(binary_size);
    give(receiver);
}

void Pair::end(Receiver &receiver) {
    const bool behind_odd =
        given_ < lines_.size() && (!lines_[given_].why.empty() || bytes(lines_[given_]) != bytes(lines_.front()));
    for (; given_ < lines_.size(); given_++) {
        const SideLine &line = lines_[given_];
        if (!line.why.empty())
            receiver.reject(where(given_), nullptr, "bad line", line.why);
        else if (behind_odd)
            receiver.reject(where(given_), &line.facts, "place unknown",
                            "stands at or behind a line that is bad or of another shape, and the size of " + binary_ +
                                " does not tell where its frame is");
        else
            receiver.reject(where(given_), &line.facts, "short file", binary_ + " ends before this frame");
    }
    if (binary_size_ > used_ && places_.size() == lines_.size())
        receiver.remark(Remark::extra_bytes, binary_,
                        std::to_string(binary_size_ - used_) + " bytes more than the frames of " + side_);
}

} // namespace cli
