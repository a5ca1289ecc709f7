#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/poisson.hpp"
#include "kernels/project.hpp"
#include "kernels/random.hpp"
#include "linear/components.hpp"

namespace toliman::linear {

namespace {

using kernels::dot;

constexpr double kSmallGain = 1e-5; // relative, ends the search
constexpr double kSmallStep = 1e-9; // of a code relative to the frame's largest product, ends the sweeps
constexpr int kMostSweeps = 1000;

double shrink(double value, double by) noexcept {
    return std::copysign(std::max(std::fabs(value) - by, 0.0), value);
}

// Rows of the arrays [count][frames] are atoms. Atom j is the sum of weight_[j][i] times frame i, and product_[j][i]
// its inner product with frame i, which is gram times weight.
class Dictionary {
  public:
    Dictionary(size_t frames, const Buffer<double> &gram, size_t pixels, const DictionaryOptions &options)
        : n_(frames), count_(options.count), gram_(gram), weight_(count_ * n_), product_(count_ * n_),
          code_(count_ * n_), covering_(n_), atoms_(count_ * count_), codes_(count_ * count_) {
        for (size_t i = 0; i < n_; i++)
            total_ += gram[i * n_ + i];
        penalty_ = options.lambda * std::sqrt(total_ / static_cast<double>(n_ * pixels));
        kernels::Rng rng(options.seed, kernels::kStreamAtoms);
        std::generate(weight_.begin(), weight_.end(), [&] { return rng.normal(); });
        for (size_t j = 0; j < count_; j++) {
            cover(&weight_[j * n_]);
            std::copy(covering_.begin(), covering_.end(), &product_[j * n_]);
            shorten(j);
        }
    }

    // Codes of all frames for the atoms as they are; what they gain: the objective without atoms less that with them.
    double encode() {
        for (size_t j = 0; j < count_; j++)
            for (size_t l = 0; l < count_; l++)
                atoms_[j * count_ + l] = dot(&weight_[j * n_], &product_[l * n_], n_);
        for (size_t i = 0; i < n_; i++)
            encode_frame(i);
        double gain = 0;
        for (size_t j = 0; j < count_; j++) {
            for (size_t i = 0; i < n_; i++)
                gain += code_[j * n_ + i] * product_[j * n_ + i] - penalty_ * std::fabs(code_[j * n_ + i]);
            for (size_t l = 0; l < count_; l++) {
                codes_[j * count_ + l] = dot(&code_[j * n_], &code_[l * n_], n_);
                gain -= codes_[j * count_ + l] * atoms_[j * count_ + l] / 2;
            }
        }
        return gain;
    }

    // Better atoms for the codes as encode() left them; an atom that no frame uses stays as it is.
    void improve() {
        for (size_t j = 0; j < count_; j++) {
            const double energy = codes_[j * count_ + j];
            if (!(energy > 0))
                continue;
            cover(&code_[j * n_]);
            step(&weight_[j * n_], &code_[j * n_], weight_, j, energy);
            step(&product_[j * n_], covering_.data(), product_, j, energy);
            shorten(j);
        }
    }

    Components components() const {
        Components out;
        out.frames = n_;
        std::vector<size_t> order(count_);
        std::iota(order.begin(), order.end(), size_t{0});
        const auto energy = [&](size_t j) { return codes_[j * count_ + j] * atoms_[j * count_ + j]; };
        std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return energy(a) > energy(b); });
        for (const size_t j : order) {
            out.series.insert(out.series.end(), &code_[j * n_], &code_[j * n_] + n_);
            out.share.push_back(total_ > 0 ? energy(j) / total_ : 0);
        }
        fix_signs(out);
        return out;
    }

    double total() const noexcept { return total_; }

  private:
    // covering_ = gram times a sparse vector
    void cover(const double *vector) noexcept {
        std::fill(covering_.begin(), covering_.end(), 0.0);
        for (size_t i = 0; i < n_; i++)
            if (vector[i] != 0)
                for (size_t l = 0; l < n_; l++)
                    covering_[l] += vector[i] * gram_[i * n_ + l];
    }

    // row += (target - the sum over l of codes_[j][l] rows[l]) / energy
    void step(double *row, const double *target, const Buffer<double> &rows, size_t j, double energy) noexcept {
        for (size_t i = 0; i < n_; i++) {
            double covered = 0;
            for (size_t l = 0; l < count_; l++)
                covered += codes_[j * count_ + l] * rows[l * n_ + i];
            row[i] += (target[i] - covered) / energy;
        }
    }

    // Atoms are at most 1 long.
    void shorten(size_t j) noexcept {
        const double length = std::sqrt(std::max(dot(&weight_[j * n_], &product_[j * n_], n_), 0.0));
        if (length <= 1)
            return;
        for (size_t i = j * n_; i < (j + 1) * n_; i++) {
            weight_[i] /= length;
            product_[i] /= length;
        }
    }

    // Cyclic coordinate descent from the frame's last codes.
    void encode_frame(size_t i) noexcept {
        double largest = 0;
        for (size_t j = 0; j < count_; j++)
            largest = std::max(largest, std::fabs(product_[j * n_ + i]));
        for (int sweep = 0; sweep < kMostSweeps; sweep++) {
            double change = 0;
            for (size_t j = 0; j < count_; j++) {
                const double *const likeness = &atoms_[j * count_];
                double &code = code_[j * n_ + i];
                double left = product_[j * n_ + i] + likeness[j] * code;
                for (size_t l = 0; l < count_; l++)
                    left -= likeness[l] * code_[l * n_ + i];
                const double better = likeness[j] > 0 ? shrink(left, penalty_) / likeness[j] : 0;
                change = std::max(change, std::fabs(better - code));
                code = better;
            }
            if (change <= kSmallStep * largest)
                return;
        }
    }

    size_t n_, count_;
    const Buffer<double> &gram_;
    Buffer<double> weight_, product_, code_; // [count][frames]
    Buffer<double> covering_;                // [frames]
    Buffer<double> atoms_, codes_;           // [count][count], inner products of the atoms and of the codes
    double total_ = 0, penalty_ = 0;
};

} // namespace

Components sparse_dictionary(size_t frames, const Buffer<double> &gram, size_t pixels,
                             const DictionaryOptions &options) {
    Dictionary dictionary(frames, gram, pixels, options);
    double gain = dictionary.encode();
    size_t done = 0;
    bool converged = false;
    while (done < options.iterations && !converged) {
        options.progress.report("dictionary", static_cast<double>(done) / static_cast<double>(options.iterations));
        dictionary.improve();
        const double better = dictionary.encode();
        converged = better - gain <= kSmallGain * better;
        gain = better;
        done++;
    }
    Components out = dictionary.components();
    out.iterations = done;
    out.converged = converged;
    out.objective = dictionary.total() > 0 ? 1 - 2 * gain / dictionary.total() : 0;
    return out;
}

} // namespace toliman::linear
