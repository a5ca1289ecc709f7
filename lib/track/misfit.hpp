// Limit of the chi-square of a folder's frames, and their distribution, from which it may follow.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/buffer.hpp"
#include "base/goodness.hpp"
#include "track/columns.hpp"

namespace toliman::track {

// The limit of frames that are measured with the scene of a calibration. Others have kOfMedian times the median, within
// bounds: a scene whose model is wrong by a chi-square of 10 is usable, one of 1000 is not.
constexpr double kCalibratedLimit = 2, kOfMedian = 4, kLeastLimit = 2, kMostLimit = 100;

// A chi-square in 256 steps per factor of 2, so that a set of frames has one median in any order.
using ChiBin = uint16_t;
constexpr ChiBin kNoBin = 0; // chi-square is not known: never a misfit
ChiBin bin_of(double chi_square) noexcept;

// Reads the goodness of fit from the cells of a ledger.
class GoodnessColumns {
  public:
    explicit GoodnessColumns(const Columns &columns);
    double chi_square(const Cells &cells) const noexcept { return number(chi_square_, cells); }
    Goodness goodness(const Cells &cells) const noexcept;
    uint32_t bad_pixels(const Cells &cells) const noexcept;

  private:
    double number(size_t column, const Cells &cells) const noexcept; // NaN without the column
    size_t count_, chi_square_, sigma_, largest_, bad_pixels_;
};

// Distribution of the chi-squares of the valid frames of a folder. Allocates nothing after construction.
class ChiSquares {
  public:
    ChiSquares();
    void add(ChiBin bin) noexcept { change(bin, 1); }
    void remove(ChiBin bin) noexcept { change(bin, -1); }
    double median() const noexcept; // within 0.2 %; NaN without frames
    // The chi-square above whose bin a frame is a misfit: `given`, or that of the median if it is 0.
    double limit(double given) const noexcept;
    // Whether a frame has a bin in (low, high].
    bool has_between(ChiBin low, ChiBin high) const noexcept;
    int64_t count() const noexcept { return count_; }

  private:
    void change(ChiBin bin, int32_t by) noexcept;
    Buffer<uint32_t> frames_; // of each bin
    int64_t count_ = 0, below_ = 0;
    ChiBin middle_ = 1; // bin of the median; below_: frames of the bins below it
};

} // namespace toliman::track
