// Method: circular orbits of one period and amplitude A are recovered with a probability that is counted in simulated
// series, whose phases are equal steps. They are the same for each amplitude and period, so that the count hardly
// scatters between them. As all that CircularSearch needs is linear in the series, or quadratic, the products of the
// noises and of a cosine and a sine of amplitude 1 serve all amplitudes. Frequencies farther than 1.5/span from that of
// the orbit have none of its power, and are left out: time and memory do not depend on the range of periods.
//
// Tried: the probability that the power of a sinusoid is significant and its period right within 10 %, by theory. It
// asked for an amplitude four times that of a search where a trend describes most of the signal, as its period is then
// found, but not within 10 %.
#include "planet/recovery.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/constants.hpp"
#include "kernels/poisson.hpp"

namespace toliman::planet {

namespace {

constexpr size_t kTrials = 400;                         // even
constexpr double kHalfWindow = 1.5, kWindowStep = 0.05; // of 1/span
constexpr double kAmplitudeAccuracy = 3e-3;             // of an amplitude, relative
constexpr int kMostDoublings = 40;

double dot(const Buffer<double> &a, const Buffer<double> &b) noexcept {
    double sum = 0;
    for (size_t i = 0; i < a.size(); i++)
        sum += a[i] * b[i];
    return sum;
}

Frequencies near(double frequency, const Series &series, const Prior &prior) noexcept {
    const double step = kWindowStep / series.span, half = kHalfWindow / series.span;
    const double first = std::max(frequency - half, prior.frequency_min);
    const double last = std::min(frequency + half, prior.frequency_max);
    return {first, step, static_cast<size_t>((last - first) / step) + 1};
}

// White noise of the weights, with errors of the functions with a prior, drawn from it.
Buffer<double> noise_of(const Detection &detection, uint64_t seed, size_t index, kernels::Rng &rng) {
    const Problem &problem = detection.problem();
    const Series &series = problem.series;
    const Buffer<double> &weights = detection.design().weights();
    Buffer<double> values(series.rows);
    kernels::poisson_kernels().gaussian(series.n, 0, {seed, index, kernels::kStreamInjectionNoise}, values.data());
    for (size_t i = 0; i < series.rows; i++)
        values[i] = weights[i] > 0 ? values[i] : 0;
    for (const Function *function : problem.functions) {
        const double error = function->precision > 0 ? rng.normal() / std::sqrt(function->precision) : 0;
        for (size_t i = 0; i < series.n; i++)
            values[i] += weights[i] * error * function->values[i];
    }
    return values;
}

// Products of one series with shapes, and with functions.
struct Products {
    std::vector<double> right, functions;

    Products(const CircularSearch &search, const std::vector<double> &along, size_t which) {
        for (size_t i = 0; i < search.all_numbers(); i++)
            (i < search.numbers() ? right : functions).push_back(along[2 * i + which]);
    }
};

// The inner product of what the functions leave of two series; both: that of the series.
double left_of(double both, const Products &a, const Products &b) noexcept {
    for (size_t j = 0; j < a.functions.size(); j++)
        both -= a.functions[j] * b.functions[j];
    return both;
}

// Series with circular orbits of one frequency.
class Trials {
  public:
    Trials(const Detection &detection, double threshold, double frequency)
        : search_(detection, threshold, near(frequency, detection.problem().series, detection.problem().prior)) {
        const Series &series = detection.problem().series;
        for (size_t i = 0; i < 2; i++) {
            const Planet planet = {{frequency, 0, 0}, {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0}};
            shapes_[i] = signal_of(series, planet);
            for (size_t row = 0; row < series.rows; row++)
                shapes_[i][row] *= detection.design().weights()[row];
        }
        signal_ = reduced(shapes_[0], shapes_[1]);
        for (size_t i = 0; i < 2; i++)
            for (size_t j = 0; j < 2; j++)
                squares_[i][j] = left_of(dot(shapes_[i], shapes_[j]), signal_[i], signal_[j]);
        kernels::Rng rng(0, kernels::kStreamInjection);
        for (size_t k = 0; k < kTrials; k += 2) {
            const Buffer<double> first = noise_of(detection, 0, k, rng);
            add(first, noise_of(detection, 0, k + 1, rng));
        }
    }

    // Amplitude of about one standard deviation.
    double unit() const noexcept {
        const double square = squares_[0][0] + squares_[1][1];
        return square > 0 ? 1 / std::sqrt(square) : HUGE_VAL;
    }

    // Whether at least this share is recovered; ends when that is known.
    bool reaches(double amplitude, double probability) const {
        double most_lost = (1 - probability) * static_cast<double>(trials_.size()) + 1e-9;
        for (size_t k = 0; k < trials_.size() && most_lost >= 0; k++)
            most_lost -= is_recovered(k, amplitude) ? 0 : 1;
        return most_lost >= 0;
    }

  private:
    struct Trial {
        std::vector<double> right;
        double cross[2], square;
    };

    bool is_recovered(size_t k, double amplitude) const {
        std::vector<double> right(search_.numbers());
        const Trial &trial = trials_[k];
        const double phase = 2 * kPi * (static_cast<double>(k) + 0.5) / static_cast<double>(trials_.size());
        const double size[] = {amplitude * std::cos(phase), amplitude * std::sin(phase)};
        for (size_t i = 0; i < right.size(); i++)
            right[i] = trial.right[i] + size[0] * signal_[0].right[i] + size[1] * signal_[1].right[i];
        double square = trial.square;
        for (size_t i = 0; i < 2; i++)
            square += 2 * size[i] * trial.cross[i] + size[i] * (size[0] * squares_[i][0] + size[1] * squares_[i][1]);
        return search_.is_planet(right.data(), square);
    }

    void add(const Buffer<double> &first, const Buffer<double> &second) {
        const std::vector<Products> both = reduced(first, second);
        for (size_t which = 0; which < 2; which++) {
            const Buffer<double> &noise = which == 0 ? first : second;
            Trial trial = {both[which].right, {}, left_of(dot(noise, noise), both[which], both[which])};
            for (size_t i = 0; i < 2; i++)
                trial.cross[i] = left_of(dot(shapes_[i], noise), signal_[i], both[which]);
            trials_.push_back(std::move(trial));
        }
    }

    std::vector<Products> reduced(const Buffer<double> &x, const Buffer<double> &y) const {
        std::vector<double> along(2 * search_.all_numbers());
        search_.set_products(x.data(), y.data(), along.data());
        return {{search_, along, 0}, {search_, along, 1}};
    }

    CircularSearch search_;
    Buffer<double> shapes_[2]; // of amplitude 1, whitened
    std::vector<Products> signal_;
    double squares_[2][2];
    std::vector<Trial> trials_;
};

} // namespace

double Recovery::recoverable(double frequency, double probability) const {
    const Trials trials(detection_, threshold_, frequency);
    double high = trials.unit(), low = 0;
    if (!std::isfinite(high))
        return HUGE_VAL;
    for (int i = 0; !trials.reaches(high, probability); i++, high *= 2) {
        if (i == kMostDoublings)
            return HUGE_VAL;
        low = high;
    }
    while (high - low > kAmplitudeAccuracy * high) {
        const double middle = (low + high) / 2;
        (trials.reaches(middle, probability) ? high : low) = middle;
    }
    return high;
}

// A planet of a cell, in noise.
Buffer<double> Recovery::injected(const InjectionCell &cell, const Units &units, size_t index,
                                  kernels::Rng &rng) const {
    const Problem &problem = detection_.problem();
    const double period = cell.period_min * std::pow(cell.period_max / cell.period_min, rng.uniform());
    const double size = cell.size_min * std::pow(cell.size_max / cell.size_min, rng.uniform());
    const double share = rng.uniform(),
                 e = cell.is_circular ? 0 : problem.prior.eccentricity_in(0, problem.prior.eccentricity_max, share);
    const double phase = 2 * kPi * rng.uniform();
    const double amplitude = cell.star < 0 ? size : units.amplitude(cell.star, period, e, size);
    const Planet planet = {{1 / period, e, rng.uniform()}, {amplitude * std::cos(phase), amplitude * std::sin(phase)}};
    const Buffer<double> signal = signal_of(problem.series, planet);
    Buffer<double> values = noise_of(detection_, cell.seed, index, rng);
    for (size_t i = 0; i < problem.series.n; i++)
        values[i] += detection_.design().weights()[i] * signal[i];
    return values;
}

const CircularSearch &Recovery::whole() const {
    std::call_once(once_,
                   [this] { whole_ = std::make_unique<CircularSearch>(detection_, threshold_, detection_.grid()); });
    return *whole_;
}

size_t Recovery::inject(const InjectionCell &cell, const Units &units) const {
    const CircularSearch &search = whole();
    std::vector<double> along(2 * search.all_numbers());
    kernels::Rng rng(cell.seed, kernels::kStreamInjection);
    size_t detected = 0;
    for (size_t i = 0; i < cell.count; i += 2) { // the products of two series take the time of one
        const Buffer<double> first = injected(cell, units, i, rng), second = injected(cell, units, i + 1, rng);
        search.set_products(first.data(), second.data(), along.data());
        const Products x(search, along, 0), y(search, along, 1);
        detected += search.is_planet(x.right.data(), left_of(dot(first, first), x, x));
        detected += i + 1 < cell.count && search.is_planet(y.right.data(), left_of(dot(second, second), y, y));
    }
    return detected;
}

} // namespace toliman::planet
