// Method: dictionary learning. Finds atoms D_j, |D_j| <= 1, and codes a that minimise, summed over the frames x,
//     |x - D a|^2 / 2 + lambda rms |a|_1,
// rms that of a pixel, by alternating from random atoms: the codes by cyclic coordinate descent (soft thresholding),
// the atoms by block coordinate descent, each step exact for its block. Stops when a step gains less than 1e-5 of the
// total gain, at a local minimum.
// All atoms remain in the span of the N frames, D_j = sum over i of weight_ji x_i, so that everything is computed from
// the N x N Gram matrix of the frames and no step touches a pixel.
// Reference: Mairal, Bach, Ponce and Sapiro 2009, Online dictionary learning for sparse coding (ICML), algorithms 1
// and 2, with all frames at once.
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

constexpr double kGainTolerance = 1e-5;  // relative gain of a step that stops the iteration
constexpr double kSweepTolerance = 1e-9; // change of a code, relative to the frame's largest inner product
constexpr int kMaxSweeps = 1000;

double soft_threshold(double value, double threshold) noexcept {
    return std::copysign(std::max(std::fabs(value) - threshold, 0.0), value);
}

// Rows of the arrays [count][frames] are atoms. Atom j is the sum over i of weight_[j][i] times frame i. product_[j][i]
// is its inner product with frame i, the row weight_[j] times the Gram matrix. code_[j][i] is its code in frame i.
class Dictionary {
  public:
    Dictionary(size_t frames, const Buffer<double> &gram, size_t pixels, const DictionaryOptions &options)
        : n_(frames), count_(options.count), gram_(gram), weight_(count_ * n_), product_(count_ * n_),
          code_(count_ * n_), gram_product_(n_), atoms_(count_ * count_), codes_(count_ * count_) {
        for (size_t i = 0; i < n_; i++)
            total_ += gram[i * n_ + i];
        penalty_ = options.lambda * std::sqrt(total_ / static_cast<double>(n_ * pixels));
        kernels::Rng rng(options.seed, kernels::kStreamAtoms);
        std::generate(weight_.begin(), weight_.end(), [&] { return rng.normal(); });
        for (size_t j = 0; j < count_; j++) {
            multiply_gram(&weight_[j * n_]);
            std::copy(gram_product_.begin(), gram_product_.end(), &product_[j * n_]);
            normalise_atom(j);
        }
    }

    // Computes the codes of all frames for the current atoms. Returns the gain: the objective without atoms minus the
    // objective with them.
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

    // Updates the atoms for the codes of the last encode(). An atom that no frame uses does not change.
    void update_atoms() {
        for (size_t j = 0; j < count_; j++) {
            const double energy = codes_[j * count_ + j];
            if (!(energy > 0))
                continue;
            multiply_gram(&code_[j * n_]);
            step(&weight_[j * n_], &code_[j * n_], weight_, j, energy);
            step(&product_[j * n_], gram_product_.data(), product_, j, energy);
            normalise_atom(j);
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
    // gram_product_ = Gram matrix times a sparse vector
    void multiply_gram(const double *vector) noexcept {
        std::fill(gram_product_.begin(), gram_product_.end(), 0.0);
        for (size_t i = 0; i < n_; i++)
            if (vector[i] != 0)
                for (size_t l = 0; l < n_; l++)
                    gram_product_[l] += vector[i] * gram_[i * n_ + l];
    }

    // row += (target - sum over l of codes_[j][l] rows[l]) / energy: the exact minimum over atom j
    void step(double *row, const double *target, const Buffer<double> &rows, size_t j, double energy) noexcept {
        for (size_t i = 0; i < n_; i++) {
            double modelled = 0;
            for (size_t l = 0; l < count_; l++)
                modelled += codes_[j * count_ + l] * rows[l * n_ + i];
            row[i] += (target[i] - modelled) / energy;
        }
    }

    // Projects atom j onto the unit ball: divides it by its length if that exceeds 1.
    void normalise_atom(size_t j) noexcept {
        const double length = std::sqrt(std::max(dot(&weight_[j * n_], &product_[j * n_], n_), 0.0));
        if (length <= 1)
            return;
        for (size_t i = j * n_; i < (j + 1) * n_; i++) {
            weight_[i] /= length;
            product_[i] /= length;
        }
    }

    // Codes of frame i by cyclic coordinate descent, starting from its last codes.
    void encode_frame(size_t i) noexcept {
        double largest = 0;
        for (size_t j = 0; j < count_; j++)
            largest = std::max(largest, std::fabs(product_[j * n_ + i]));
        for (int sweep = 0; sweep < kMaxSweeps; sweep++) {
            double change = 0;
            for (size_t j = 0; j < count_; j++) {
                const double *const atom_row = &atoms_[j * count_];
                double &code = code_[j * n_ + i];
                double remaining = product_[j * n_ + i] + atom_row[j] * code;
                for (size_t l = 0; l < count_; l++)
                    remaining -= atom_row[l] * code_[l * n_ + i];
                const double updated = atom_row[j] > 0 ? soft_threshold(remaining, penalty_) / atom_row[j] : 0;
                change = std::max(change, std::fabs(updated - code));
                code = updated;
            }
            if (change <= kSweepTolerance * largest)
                return;
        }
    }

    size_t n_, count_;
    const Buffer<double> &gram_;
    Buffer<double> weight_, product_, code_; // [count][frames]
    Buffer<double> gram_product_;            // [frames]
    Buffer<double> atoms_, codes_;           // [count][count], Gram matrices of the atoms and of the codes
    double total_ = 0, penalty_ = 0;         // sum of squares of all frames; lambda rms
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
        dictionary.update_atoms();
        const double updated = dictionary.encode();
        converged = updated - gain <= kGainTolerance * updated;
        gain = updated;
        done++;
    }
    Components out = dictionary.components();
    out.iterations = done;
    out.converged = converged;
    // |x - D a|^2/2 + penalty |a|_1 = |x|^2/2 - gain, as a share of |x|^2/2.
    out.objective = dictionary.total() > 0 ? 1 - 2 * gain / dictionary.total() : 0;
    return out;
}

} // namespace toliman::linear
