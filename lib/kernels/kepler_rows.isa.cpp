// Method: Kepler's equation g(E) = E - e sin E - M = 0 from E = M + 0.85 e sign(M), by steps of third order,
//     d1 = -g/g', d2 = -g/(g' + d1 g''/2), d3 = -g/(g' + d2 g''/2 + d2^2 g'''/6).
// Two steps leave 1e-15 up to e = 0.5, three 1e-13 up to 0.951, four 1e-14 up to 0.991. There are no conditions, so
// that loops vectorise. The last step is below 1e-3: cosine and sine of E + d3 follow from those of E by a polynomial
// in d3.
// Rejected: the starts of Encke, which needs a square root and a cosine, and of Mikkola, which needs a cube root.
//
// Reference: Danby, Fundamentals of Celestial Mechanics, ch. 6
#include "kernels/kepler_rows.hpp"

#include "kernels/cis.hpp"

namespace toliman::kernels {
namespace TOLIMAN_ISA {
namespace {

constexpr double kTurn = 6.283185307179586476925, kPerTurn = 0.15915494309189533577;

constexpr size_t kBlock = 64;

// Mean and eccentric anomalies of a block, with cosine and sine of the eccentric one.
struct alignas(64) Block {
    double mean[kBlock], anomaly[kBlock], cosine[kBlock], sine[kBlock];
};

inline void start(const KeplerOrbit &orbit, const double *__restrict t, size_t n, Block &block) noexcept {
    const double frequency = orbit.frequency, first = orbit.anomaly, lead = 0.85 * orbit.eccentricity;
    for (size_t i = 0; i < n; i++) {
        const double mean = kTurn * reduce_cycles(frequency * t[i] + first);
        block.mean[i] = mean;
        block.anomaly[i] = mean + __builtin_copysign(lead, mean);
    }
}

// The change of E in one step; cosine and sine are those before it.
inline double change(double e, double mean, double anomaly, double &cosine, double &sine) noexcept {
    cis_cycles(reduce_cycles(anomaly * kPerTurn), cosine, sine);
    const double e_sine = e * sine, e_cosine = e * cosine, slope = 1.0 - e_cosine, g = (anomaly - mean) - e_sine;
    const double d1 = -g / slope, d2 = -g / (slope + 0.5 * d1 * e_sine);
    return -g / (slope + 0.5 * d2 * e_sine + d2 * d2 * e_cosine * 0.16666666666666666);
}

inline void step(double e, size_t n, Block &block) noexcept {
    for (size_t i = 0; i < n; i++) {
        double cosine, sine;
        block.anomaly[i] += change(e, block.mean[i], block.anomaly[i], cosine, sine);
    }
}

inline void last_step(double e, size_t n, Block &block) noexcept {
    for (size_t i = 0; i < n; i++) {
        double cosine, sine;
        const double d = change(e, block.mean[i], block.anomaly[i], cosine, sine), square = d * d;
        const double c = 1.0 - square * (0.5 - square * 0.041666666666666664);
        const double s = d * (1.0 - square * (0.16666666666666666 - square * 0.008333333333333333));
        block.cosine[i] = cosine * c - sine * s;
        block.sine[i] = sine * c + cosine * s;
    }
}

// Calls use(first, count, block) for blocks of samples.
template <class Use> inline void in_blocks(const KeplerOrbit &orbit, const double *t, size_t n, Use use) noexcept {
    Block block;
    for (size_t first = 0; first < n; first += kBlock) {
        const size_t count = n - first < kBlock ? n - first : kBlock;
        start(orbit, t + first, count, block);
        step(orbit.eccentricity, count, block);
        if (orbit.eccentricity > 0.5)
            step(orbit.eccentricity, count, block);
        if (orbit.eccentricity > 0.951)
            step(orbit.eccentricity, count, block);
        last_step(orbit.eccentricity, count, block);
        use(first, count, block);
    }
}

void position(const KeplerOrbit &orbit, const double *__restrict t, size_t n, double *__restrict x,
              double *__restrict y) noexcept {
    const double e = orbit.eccentricity, root = __builtin_sqrt((1.0 - e) * (1.0 + e));
    in_blocks(orbit, t, n, [&](size_t first, size_t count, const Block &block) {
        for (size_t i = 0; i < count; i++) {
            x[first + i] = block.cosine[i] - e;
            y[first + i] = root * block.sine[i];
        }
    });
}

void velocity(const KeplerOrbit &orbit, const double *__restrict t, size_t n, double *__restrict x,
              double *__restrict y) noexcept {
    const double e = orbit.eccentricity, root = __builtin_sqrt((1.0 - e) * (1.0 + e));
    in_blocks(orbit, t, n, [&](size_t first, size_t count, const Block &block) {
        for (size_t i = 0; i < count; i++) {
            const double part = 1.0 / (1.0 - e * block.cosine[i]);
            x[first + i] = part * (block.cosine[i] - e) + e;
            y[first + i] = part * (root * block.sine[i]);
        }
    });
}

typedef double Vector __attribute__((vector_size(32), aligned(8), may_alias));
constexpr size_t kVectors = 4; // in flight, so that additions need not wait for each other
static_assert(kRowLanes * sizeof(double) == kVectors * sizeof(Vector));

void products(const double *rows, size_t count, const double *x, const double *y, size_t n, double *out) noexcept {
    const auto *const xs = reinterpret_cast<const Vector *>(x), *const ys = reinterpret_cast<const Vector *>(y);
    for (size_t j = 0; j < count; j++) {
        const auto *const row = reinterpret_cast<const Vector *>(rows + j * n);
        Vector with_x[kVectors] = {}, with_y[kVectors] = {};
        for (size_t i = 0; i < n * sizeof(double) / sizeof(Vector); i += kVectors)
            for (size_t k = 0; k < kVectors; k++) {
                with_x[k] += row[i + k] * xs[i + k];
                with_y[k] += row[i + k] * ys[i + k];
            }
        const Vector sum_x = (with_x[0] + with_x[1]) + (with_x[2] + with_x[3]);
        const Vector sum_y = (with_y[0] + with_y[1]) + (with_y[2] + with_y[3]);
        out[2 * j] = (sum_x[0] + sum_x[1]) + (sum_x[2] + sum_x[3]);
        out[2 * j + 1] = (sum_y[0] + sum_y[1]) + (sum_y[2] + sum_y[3]);
    }
}

} // namespace
} // namespace TOLIMAN_ISA

extern const KeplerKernels TOLIMAN_ISA_TABLE(kepler);
const KeplerKernels TOLIMAN_ISA_TABLE(kepler) = {TOLIMAN_ISA::position, TOLIMAN_ISA::velocity, TOLIMAN_ISA::products};

} // namespace toliman::kernels
