// Method: Schur complement in double, as period/stream/projection.cpp: u_x = L^-1 (sum w b x) for x = cosine and sine,
//     cc = (1 + C2)/2 - u_c . u_c,  ss = (1 - C2)/2 - u_s . u_s,  cs = S2/2 - u_c . u_s,
//     yc = YC - u_c . u_y,          ys = YS - u_s . u_y
// with sums divided by W, and the power (yc^2 ss - 2 yc ys cs + ys^2 cc)/(V (cc ss - cs^2)). Frequencies are taken 64
// at a time, so that the loops over functions run over arrays. Where digits cancel, the caller uses extended precision.
#include "kernels/power_rows.hpp"

#include "kernels/limb_reader.hpp"
#include "kernels/power.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr size_t kAtOnce = 64;
using Row = double[kAtOnce];

// The sums of a block of frequencies, divided by W.
class Sums {
  public:
    Sums(const int64_t *const *lo, const int64_t *const *hi, const PowerRowsShared &shared) noexcept
        : lo_(lo), hi_(hi), first_(shared.weight, 51), low_(static_cast<double>(shared.samples), 51),
          value_(shared.weight * shared.size, 62), unit_(power_of_two(first_.shift() - 50) / shared.weight),
          low_unit_(power_of_two(low_.shift() - 50) * 0x1p-50 / shared.weight),
          value_unit_(power_of_two(value_.shift() - 50) / shared.weight) {}

    // A sum of weights, at most W, of two limbs.
    void read(size_t high, size_t low, size_t from, size_t n, Row &out) const noexcept {
        for (size_t k = 0; k < n; k++)
            out[k] = first_.small(lo_[high][from + k], hi_[high][from + k]) * unit_ +
                     low_.small(lo_[low][from + k], hi_[low][from + k]) * low_unit_;
    }
    // A sum of values, of which the first limb may exceed 2^51 units.
    void read_values(size_t high, size_t low, size_t from, size_t n, Row &out) const noexcept {
        for (size_t k = 0; k < n; k++)
            out[k] = value_.large(lo_[high][from + k], hi_[high][from + k]) * value_unit_ +
                     low_.small(lo_[low][from + k], hi_[low][from + k]) * low_unit_;
    }

  private:
    const int64_t *const *lo_, *const *hi_;
    Reader first_, low_, value_;
    double unit_, low_unit_, value_unit_;
};

struct alignas(64) Block {
    Row cosine[kMaxRows], sine[kMaxRows]; // u_c, u_s
    Row cc, ss, cs, yc, ys, all_c;        // all_c: sum of cos^2
};

void project(const Sums &sums, size_t i, size_t from, size_t n, const PowerRowsShared &shared, Block &block) noexcept {
    const size_t f = shared.function[i], row = f == 0 ? size_t{kC1} : kSums + (f - 1) * kFunctionSums;
    const size_t low = f == 0 ? size_t{kC1Low} : row + kFunctionCLow;
    sums.read(row, low, from, n, block.cosine[i]);
    sums.read(row + 1, low + 1, from, n, block.sine[i]);
    double *__restrict const cosine = block.cosine[i], *__restrict const sine = block.sine[i];
    for (size_t j = 0; j < i; j++) {
        const double *__restrict const before_c = block.cosine[j], *__restrict const before_s = block.sine[j];
        const double factor = shared.factor[i][j];
        for (size_t k = 0; k < n; k++) {
            cosine[k] -= factor * before_c[k];
            sine[k] -= factor * before_s[k];
        }
    }
    const double inverse = shared.inverse[i], y = shared.y[i];
    for (size_t k = 0; k < n; k++) {
        const double c = cosine[k] * inverse, s = sine[k] * inverse;
        cosine[k] = c;
        sine[k] = s;
        block.cc[k] -= c * c;
        block.ss[k] -= s * s;
        block.cs[k] -= c * s;
        block.yc[k] -= c * y;
        block.ys[k] -= s * y;
    }
}

size_t power(const int64_t *const *lo, const int64_t *const *hi, size_t n, const PowerRowsShared &shared,
             double *out) noexcept {
    const Sums sums(lo, hi, shared);
    Block block;
    size_t ill_conditioned = 0;
    for (size_t from = 0; from < n; from += kAtOnce) {
        const size_t some = n - from < kAtOnce ? n - from : kAtOnce;
        sums.read(kC2, kC2Low, from, some, block.cc);
        sums.read(kS2, kS2Low, from, some, block.cs);
        sums.read_values(kYC, kYCLow, from, some, block.yc);
        sums.read_values(kYS, kYSLow, from, some, block.ys);
        for (size_t k = 0; k < some; k++) {
            const double half = 0.5 * block.cc[k];
            block.cc[k] = block.all_c[k] = 0.5 + half;
            block.ss[k] = 0.5 - half;
            block.cs[k] *= 0.5;
        }
        for (size_t i = 0; i < shared.used; i++)
            project(sums, i, from, some, shared, block);
        for (size_t k = 0; k < some; k++) {
            const double cc = block.cc[k], ss = block.ss[k], cs = block.cs[k], yc = block.yc[k], ys = block.ys[k];
            const double determinant = cc * ss - cs * cs, cross = yc * cs;
            const double explained =
                (yc * yc * ss - (cross + cross) * ys + ys * ys * cc) / (determinant * shared.spread);
            const double positive = explained > 0.0 ? explained : 0.0, bounded = positive < 1.0 ? positive : 1.0;
            const bool less = !(cc > kLeastRest * block.all_c[k]) | !(ss > kLeastRest * (1.0 - block.all_c[k])) |
                              !(determinant > kLeastRowsDeterminant);
            out[from + k] = less ? kNeedsMore : bounded;
            ill_conditioned += less;
        }
    }
    return ill_conditioned;
}

} // namespace
} // namespace TOLIMAN_ISA

const PowerRowsKernels TOLIMAN_ISA_TABLE(power_rows) = {TOLIMAN_ISA::power};

} // namespace toliman::kernels
