// Method: modified Gram-Schmidt, twice where it cancels, in long double, on the whitened functions w b_j with one more
// row per prior, sqrt(precision): a prior is an observation of the coefficient. With Q R = [w B; P] and the residual r
// of the values,
//     ln evidence = -|r|^2/2 + sum ln w - sum ln R_jj + constants.
// Signals have zeros in the rows of the priors, so that only the measurements' rows of Q are kept.
#include "planet/design.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::planet {

namespace {

using Real = long double;
using Column = std::vector<Real>;

constexpr Real kLeastIndependent = 1e-20L; // share of the square of a function that is left by those before it
constexpr Real kCancelled = 1e-3L;         // share below which a second pass removes what rounding left

Real dot(const Column &a, const Column &b) noexcept {
    Real sum = 0;
    for (size_t i = 0; i < a.size(); i++)
        sum += a[i] * b[i];
    return sum;
}

// Removes from x its parts along the directions, which it returns.
Column remove(const std::vector<Column> &directions, Column &x) {
    Column parts(directions.size());
    const Real before = dot(x, x);
    for (int pass = 0; pass < 2 && (pass == 0 || dot(x, x) < kCancelled * before); pass++)
        for (size_t j = 0; j < directions.size(); j++) {
            const Real along = dot(directions[j], x);
            for (size_t i = 0; i < x.size(); i++)
                x[i] -= along * directions[j][i];
            parts[j] += along;
        }
    return parts;
}

} // namespace

Design::Design(const Series &series, const std::vector<const Function *> &functions, const Buffer<double> &values,
               double jitter)
    : all_(functions.size()), rows_(series.rows), dependent_(functions.size()), weights_(series.weights(jitter)) {
    const size_t n = series.n;
    size_t priors = 0;
    for (const Function *function : functions)
        priors += function->precision > 0;
    Column data(n + priors);
    Real log_evidence = 0;
    for (size_t i = 0; i < n; i++) {
        data[i] = static_cast<Real>(weights_[i]) * values[i];
        log_evidence += weights_[i] > 0 ? std::log(static_cast<Real>(weights_[i])) : 0;
    }
    std::vector<Column> directions;
    size_t row = n;
    for (size_t j = 0; j < functions.size(); j++) {
        const Function &function = *functions[j];
        Column column(n + priors);
        for (size_t i = 0; i < n; i++)
            column[i] = static_cast<Real>(weights_[i]) * function.values[i];
        if (function.precision > 0) {
            column[row] = std::sqrt(static_cast<Real>(function.precision));
            data[row] = column[row] * function.target;
            row++;
        }
        const Real before = dot(column, column);
        Column parts = remove(directions, column);
        const Real left = dot(column, column);
        if (!(left > kLeastIndependent * before)) {
            dependent_ = std::min(dependent_, j); // what is left is rounding: its coefficient is 0
            continue;
        }
        const Real length = std::sqrt(left);
        for (Real &value : column)
            value /= length;
        directions.push_back(std::move(column));
        parts.push_back(length);
        triangle_.push_back(std::move(parts));
        index_.push_back(j);
        log_evidence -= std::log(left) / 2;
        free_ += function.precision <= 0;
    }
    along_ = remove(directions, data);
    const Real square = dot(data, data);
    count_ = directions.size();
    table_.assign((count_ + 1) * rows_, 0.0);
    directions.push_back(std::move(data)); // the residuals: one call of the kernel multiplies with Q and with them
    for (size_t j = 0; j <= count_; j++)
        for (size_t i = 0; i < n; i++)
            table_[j * rows_ + i] = static_cast<double>(directions[j][i]);
    square_ = static_cast<double>(square);
    log_null_ = static_cast<double>(log_evidence - square / 2);
}

std::vector<double> Design::leverages() const {
    std::vector<double> leverages(rows_);
    for (size_t j = 0; j < count_; j++)
        for (size_t i = 0; i < rows_; i++)
            leverages[i] += table_[j * rows_ + i] * table_[j * rows_ + i];
    return leverages;
}

// R x = Q^T y by back substitution.
std::vector<double> Design::coefficients() const {
    std::vector<double> coefficients(all_);
    Column solved(count_);
    for (size_t i = count_; i-- > 0;) {
        Real sum = along_[i];
        for (size_t j = i + 1; j < count_; j++)
            sum -= triangle_[j][i] * solved[j];
        solved[i] = sum / triangle_[i][i];
        coefficients[index_[i]] = static_cast<double>(solved[i]);
    }
    return coefficients;
}

// (R^T R)^-1 = R^-1 R^-T: the weights contain the sigmas, so that no factor is missing.
std::vector<double> Design::covariance() const {
    std::vector<Column> inverse(count_, Column(count_)); // inverse[j][i] = (R^-1)_ij, i <= j
    for (size_t j = 0; j < count_; j++) {
        inverse[j][j] = 1 / triangle_[j][j];
        for (size_t i = j; i-- > 0;) {
            Real sum = 0;
            for (size_t l = i + 1; l <= j; l++)
                sum -= triangle_[l][i] * inverse[j][l];
            inverse[j][i] = sum / triangle_[i][i];
        }
    }
    std::vector<double> covariance(all_ * all_);
    for (size_t a = 0; a < count_; a++)
        for (size_t b = 0; b < count_; b++) {
            Real sum = 0;
            for (size_t j = std::max(a, b); j < count_; j++)
                sum += inverse[j][a] * inverse[j][b];
            covariance[index_[a] * all_ + index_[b]] = static_cast<double>(sum);
        }
    return covariance;
}

void Design::project(double *x) const {
    std::vector<double> along(count_);
    for (size_t j = 0; j < count_; j++)
        for (size_t i = 0; i < rows_; i++)
            along[j] += table_[j * rows_ + i] * x[i];
    for (size_t j = 0; j < count_; j++)
        for (size_t i = 0; i < rows_; i++)
            x[i] -= along[j] * table_[j * rows_ + i];
}

} // namespace toliman::planet
