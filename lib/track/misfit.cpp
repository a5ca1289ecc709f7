// Method: frames above a limit of chi-square are misfits and stay out of the sums. Without a given limit it follows
// from the median of the folder's frames, so that it changes as frames arrive. The order of arrival must not change a
// bit: the limit is a function of the set of valid frames (chi-squares are counted in bins, and a frame is a misfit if
// its bin is above that of the limit), and a frame whose verdict changes with the limit is pushed or retracted, which
// is exact.
#include "track/misfit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace toliman::track {

namespace {

constexpr int kSteps = 256; // equal ones from a power of 2 to the next: exact, as frexp and ldexp are
constexpr int kLeastPower = -32, kMostPower = 96;
constexpr size_t kBins = static_cast<size_t>(kMostPower - kLeastPower) * kSteps;

// A place within a bin: 0 its lower end, 1 its upper end.
double chi_square_in(ChiBin bin, double place) noexcept {
    const int step = bin - 1;
    return std::ldexp(1 + (step % kSteps + place) / kSteps, kLeastPower + step / kSteps);
}

} // namespace

ChiBin bin_of(double chi_square) noexcept {
    if (std::isnan(chi_square))
        return kNoBin;
    const double least = std::ldexp(1.0, kLeastPower), most = std::ldexp(1.0, kMostPower - 1);
    int power = 0;
    const double fraction = std::frexp(std::clamp(chi_square, least, most), &power); // in [0.5, 1)
    const auto step = static_cast<int>((2 * fraction - 1) * kSteps);
    return static_cast<ChiBin>((power - 1 - kLeastPower) * kSteps + step + 1);
}

GoodnessColumns::GoodnessColumns(const Columns &columns)
    : count_(columns.count()), chi_square_(columns.find(name_of(OwnColumn::chi_square))),
      sigma_(columns.find(name_of(OwnColumn::chi_square_sigma))),
      largest_(columns.find(name_of(OwnColumn::largest_residual))),
      bad_pixels_(columns.find(name_of(OwnColumn::bad_pixels))) {}

double GoodnessColumns::number(size_t column, const Cells &cells) const noexcept {
    return column < count_ ? with_bits<double>(cells[column]) : std::numeric_limits<double>::quiet_NaN();
}

Goodness GoodnessColumns::goodness(const Cells &cells) const noexcept {
    return goodness_of(number(chi_square_, cells), number(sigma_, cells), number(largest_, cells), kFrameSigmas);
}

uint32_t GoodnessColumns::bad_pixels(const Cells &cells) const noexcept {
    return bad_pixels_ < count_ ? static_cast<uint32_t>(cells[bad_pixels_]) : 0;
}

ChiSquares::ChiSquares() : frames_(kBins + 1) {}

// Keeps middle_ at the lower median: at most half of the frames are below it, and at most half above.
void ChiSquares::change(ChiBin bin, int32_t by) noexcept {
    if (bin == kNoBin)
        return;
    frames_[bin] += static_cast<uint32_t>(by);
    count_ += by;
    below_ += bin < middle_ ? by : 0;
    const int64_t rank = (count_ - 1) / 2; // of the median, from 0
    while (middle_ > 1 && rank < below_)
        below_ -= frames_[--middle_];
    while (middle_ < kBins && rank >= below_ + frames_[middle_])
        below_ += frames_[middle_++];
}

double ChiSquares::median() const noexcept {
    return count_ > 0 ? chi_square_in(middle_, 0.5) : std::numeric_limits<double>::quiet_NaN();
}

double ChiSquares::limit(double given) const noexcept {
    if (given > 0)
        return given;
    return count_ > 0 ? std::clamp(kOfMedian * chi_square_in(middle_, 1), kLeastLimit, kMostLimit) : kMostLimit;
}

bool ChiSquares::has_between(ChiBin low, ChiBin high) const noexcept {
    for (size_t bin = size_t{low} + 1; bin <= high; bin++)
        if (frames_[bin] > 0)
            return true;
    return false;
}

} // namespace toliman::track
