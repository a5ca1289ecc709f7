// Method: u_k are the whitened images, scaled to norm 1. Gram-Schmidt in the order of the scene drops those that are
// combinations of the images before them, as in every estimator, and gives the coordinates of all in an orthonormal
// basis. The rest needs these short vectors only. With d_k, the remainder of u_k after the projection of all others,
//     u_k = sum over j of c_j u_j + d_k,   c_j = <u_k, e_j> / |e_j|^2,
// where e_j is the remainder of u_j after the projection of all others but u_k. The image with the smallest |d_k| is
// reported and left out until no |d_k| is below kNearlyDependent: one message per dependence, not one for each image in
// it. Projections, because |d_k| = 1/sqrt((G^-1)_kk) by the inverse of the matrix G of inner products would lose half
// of the digits.
#include "information/dependence.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/text.hpp"
#include "kernels/project.hpp"

namespace toliman::information {

namespace {

constexpr double kNearlyDependent = 1e-2; // remainder, as a fraction of the norm
constexpr double kTie = 1.001;            // of remainders that differ by rounding, the last image has the smallest
constexpr size_t kMostParts = 3;          // of a combination, in a message
constexpr double kSmallestPart = 0.01;

using Numbers = std::vector<size_t>; // of images
using Parts = std::vector<std::pair<double, size_t>>;

class Dependence {
  public:
    explicit Dependence(const FrameModel &model)
        : model_(model), count_(model.projected.size()), coordinates_(count_ * count_) {
        set_coordinates();
    }

    void warn(const Log &log) const;

  private:
    void set_coordinates();
    const double *unit(size_t k) const noexcept { return &coordinates_[k * count_]; }
    const char *name(size_t k) const noexcept { return model_.projected[k].name.c_str(); }
    Buffer<double> remainder_of(size_t k, const Numbers &others) const;
    double norm_after(size_t k, const Numbers &others) const;
    Parts parts_of(size_t k, const Numbers &others) const;
    std::string combination(size_t k, const Numbers &others) const;
    void warn_of_dropped(size_t k, const Numbers &before, const Log &log) const;

    const FrameModel &model_;
    size_t count_;
    Buffer<double> coordinates_; // [count][count]; 0 for an image of zeros
    Numbers kept_;               // images that are not dropped
};

Numbers without(const Numbers &numbers, size_t k) {
    Numbers rest;
    std::copy_if(numbers.begin(), numbers.end(), std::back_inserter(rest), [k](size_t one) { return one != k; });
    return rest;
}

void scale(Buffer<double> &image, double factor) {
    for (double &value : image)
        value *= factor;
}

void Dependence::set_coordinates() {
    const size_t n = model_.variance.size();
    Buffer<double> basis, image(n);
    basis.reserve(checked_product(count_, n, "projected images"));
    for (size_t k = 0; k < count_; k++) {
        kernels::whiten(model_.projected[k].image.data(), model_.variance.data(), n, image.data());
        const double norm = std::sqrt(kernels::dot(image.data(), image.data(), n));
        if (!(norm > 0))
            continue;
        scale(image, 1 / norm);
        Buffer<double> rest = image;
        const double after = kernels::project_out_twice(basis.data(), kept_.size(), n, rest.data()).after;
        if (after > 0) {
            scale(rest, 1 / after);
            basis.insert(basis.end(), rest.begin(), rest.end());
            kept_.push_back(k);
        }
        for (size_t j = 0; j < kept_.size(); j++)
            coordinates_[k * count_ + j] = kernels::dot(&basis[j * n], image.data(), n);
    }
}

Buffer<double> Dependence::remainder_of(size_t k, const Numbers &others) const {
    Buffer<double> basis, rest(unit(k), unit(k) + count_);
    for (const size_t other : others)
        basis.insert(basis.end(), unit(other), unit(other) + count_);
    const size_t rank = kernels::orthonormalise(basis.data(), others.size(), count_);
    kernels::project_out_twice(basis.data(), rank, count_, rest.data());
    return rest;
}

double Dependence::norm_after(size_t k, const Numbers &others) const {
    const Buffer<double> rest = remainder_of(k, others);
    return std::sqrt(kernels::dot(rest.data(), rest.data(), count_));
}

// The coefficients c_j of image k with the numbers j of the images, the largest first.
Parts Dependence::parts_of(size_t k, const Numbers &others) const {
    Parts parts;
    for (const size_t other : others) {
        const Buffer<double> rest = remainder_of(other, without(others, other));
        const double square = kernels::dot(rest.data(), rest.data(), count_);
        const double part = square > 0 ? kernels::dot(unit(k), rest.data(), count_) / square : 0;
        if (std::fabs(part) >= kSmallestPart)
            parts.emplace_back(part, other);
    }
    std::stable_sort(parts.begin(), parts.end(),
                     [](const auto &a, const auto &b) { return std::fabs(a.first) > std::fabs(b.first); });
    return parts;
}

// "focus (0.71), roll (-0.70)"; with "..." for further parts.
std::string Dependence::combination(size_t k, const Numbers &others) const {
    std::string list;
    const Parts parts = parts_of(k, others);
    for (size_t i = 0; i < std::min(parts.size(), kMostParts); i++) {
        char text[64];
        print_text(text, sizeof text, "%s%s (%.2f)", i > 0 ? ", " : "", name(parts[i].second), parts[i].first);
        list += text;
    }
    return parts.size() > kMostParts ? list + ", ..." : list;
}

void Dependence::warn_of_dropped(size_t k, const Numbers &before, const Log &log) const {
    const char *const source = model_.source.c_str();
    const double *const end = unit(k) + count_;
    if (std::all_of(unit(k), end, [](double value) { return value == 0; }))
        log.warn("%s: preprocess.project: %s changes no pixel: it is dropped", source, name(k));
    else
        log.warn("%s: preprocess.project: %s is a combination of %s: it is dropped", source, name(k),
                 combination(k, before).c_str());
}

void Dependence::warn(const Log &log) const {
    Numbers left;
    for (size_t k = 0; k < count_; k++)
        if (left.size() < kept_.size() && kept_[left.size()] == k)
            left.push_back(k);
        else
            warn_of_dropped(k, left, log);
    while (!left.empty()) {
        double smallest = 1;
        size_t found = left.front();
        for (const size_t k : left)
            if (const double norm = norm_after(k, without(left, k)); norm < kTie * smallest) {
                smallest = norm;
                found = k;
            }
        if (smallest >= kNearlyDependent)
            return;
        left = without(left, found);
        log.warn("%s: preprocess.project: %s is nearly a combination of %s: %.2g of its norm remains",
                 model_.source.c_str(), name(found), combination(found, left).c_str(), smallest);
    }
}

} // namespace

void warn_of_dependence(const FrameModel &model, const Log &log) {
    if (log.call != nullptr)
        Dependence(model).warn(log);
}

} // namespace toliman::information
