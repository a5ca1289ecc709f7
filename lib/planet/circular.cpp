// Method: the Bayes factor of a planet on circular orbits, the sum over frequencies of that with the amplitudes
// marginalised (marginal.hpp), with the prior of the frequency. Eccentricity and its prior cancel nearly: of circular
// orbits of alpha Centauri in three years, log10 of the Bayes factor differs from that of a search by 0.03 +- 0.08 at
// 250 d, where the threshold is 2, and is too low by 0.3 to 0.7 beyond 600 d, where the amplitude that reaches the
// threshold is then too large by some 5 %. Frequencies whose gain is far below the highest are left out.
//
// A search gives three reasons against such planets: odds, the false alarm probability of the sinusoid, and the edges
// of the prior. The posterior of the period is wider with eccentric orbits, by a factor of some 1.7 at long periods, so
// that far less than the share of a search is allowed at the edges: measured with searches of 4096 samples at 500 to
// 900 d, the edge at 1000 d, `make planets`.
//
// Rejected: a second harmonic as two more amplitudes, whose odds are no better and whose edges are too wide.
#include "planet/circular.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/kepler_rows.hpp"
#include "planet/verdict.hpp"

namespace toliman::planet {

namespace {

constexpr double kGainCut = 20; // of the gain, below the highest
constexpr double kShareOfCircular = 0.005;

} // namespace

CircularSearch::CircularSearch(const Detection &detection, double threshold, const Frequencies &frequencies)
    : detection_(detection), threshold_(threshold), frequencies_(frequencies),
      size_(detection.problem().series.amplitudes()), scales_(detection.problem().prior.scales.size()),
      moments_(frequencies.count), whole_(frequencies.count), edge_(frequencies.count),
      shapes_(frequencies.count * size_ * detection.problem().series.rows) {
    const Series &series = detection.problem().series;
    const Design &design = detection.design();
    ShapeWork work(series);
    for (size_t i = 0; i < frequencies.count; i++) {
        const Orbit orbit = {frequencies.at(i), 0, 0};
        moments_[i] = work.moments(series, design, orbit);
        std::fill(std::begin(moments_[i].right), std::end(moments_[i].right), 0.0);
        for (const double scale : detection.problem().prior.scales)
            fits_.push_back(fit_amplitudes(moments_[i], scale));
        set_cell(i);
        double *const shapes = &shapes_[i * size_ * series.rows];
        set_shapes(series, orbit, shapes);
        for (size_t j = 0; j < size_; j++) {
            double *const shape = shapes + j * series.rows;
            for (size_t row = 0; row < series.rows; row++)
                shape[row] *= design.weights()[row];
            design.project(shape);
        }
    }
}

void CircularSearch::set_products(const double *x, const double *y, double *along) const noexcept {
    const kernels::KeplerKernels &kernel = kernels::kepler_kernels();
    const Design &design = detection_.design();
    const size_t rows = detection_.problem().series.rows;
    kernel.products(shapes_.data(), numbers(), x, y, rows, along);
    kernel.products(design.table(), design.functions(), x, y, rows, along + 2 * numbers());
}

bool CircularSearch::is_planet(const double *right, double square) const {
    std::vector<double> gains(moments_.size());
    for (size_t i = 0; i < gains.size(); i++) {
        CircularPair pair = circular_pair(moments_[i]);
        pair.right[0] = right[i * size_];
        pair.right[1] = right[i * size_ + 1];
        gains[i] = pair.gain();
    }
    const auto best = static_cast<size_t>(std::max_element(gains.begin(), gains.end()) - gains.begin());
    if (std::log10(std::max(1 - gains[best] / square, 1e-300)) > detection_.log10_threshold())
        return false; // the sinusoid leaves too much of the sum of squares: its false alarm probability is too high
    // With a prior uniform in ln f, a planet needs
    //     BF = sum over i of BF_i whole_i/f_i / ln(f_max/f_min) >= 10^threshold.
    // Both sides are multiplied by exp(-G/2) ln(f_max/f_min), G the highest gain, as exp(G/2) may overflow.
    const Prior &prior = detection_.problem().prior;
    const double log_range = std::log(prior.frequency_max / prior.frequency_min);
    const double needed = std::exp(threshold_ * std::log(10.0) - gains[best] / 2) * log_range;
    const auto mass = [&](size_t i) {
        return bayes(i, right + i * size_, gains[best] / 2) / frequencies_.at(i) * whole_[i];
    };
    double all = mass(best), edges = all * edge_[best];
    for (size_t i = 0; i < gains.size() && (all < needed || has_edge_); i++) {
        if (i == best || gains[i] < gains[best] - kGainCut)
            continue;
        const double one = mass(i);
        all += one;
        edges += one * edge_[i];
    }
    return all >= needed && edges <= kShareOfCircular * kMostAtEdge * all;
}

// The Bayes factor at a frequency, times exp(-least): as in marginal.cpp, with factors that are known.
double CircularSearch::bayes(size_t i, const double *right, double least) const noexcept {
    double sum = 0;
    for (size_t k = i * scales_; k < (i + 1) * scales_; k++) {
        const AmplitudeFit &fit = fits_[k];
        double solved[kMostAmplitudes], square = 0;
        for (size_t j = 0; j < size_; j++) {
            double rest = right[j];
            for (size_t l = 0; l < j; l++)
                rest -= fit.factor[j][l] * solved[l];
            solved[j] = rest / fit.factor[j][j];
            square += solved[j] * solved[j];
        }
        sum += std::exp(square / 2 + fit.log_bayes - least);
    }
    return sum / static_cast<double>(scales_);
}

// The cell of a frequency; those at the ends of the prior end there.
void CircularSearch::set_cell(size_t i) {
    const Prior &prior = detection_.problem().prior;
    const double least = prior.frequency_min, most = prior.frequency_max, at = frequencies_.at(i);
    const double from = std::max(at - frequencies_.step / 2, least);
    const double to = at + frequencies_.step > most ? most : at + frequencies_.step / 2;
    const double edges =
        std::max(std::min(to, kNearEdge * least) - from, 0.0) + std::max(to - std::max(from, most / kNearEdge), 0.0);
    whole_[i] = to - from;
    edge_[i] = std::min(edges / (to - from), 1.0);
    has_edge_ = has_edge_ || edges > 0;
}

} // namespace toliman::planet
