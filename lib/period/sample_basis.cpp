// Method: Gram-Schmidt orthonormalisation, twice, of the nuisance functions at the samples, weighted; a prior of
// precision p is a row with the value sqrt(p) in its function and 0 elsewhere. Projections then lose no digits to the
// condition of the functions. In long double.
// Reference: Bjorck (1996), Numerical Methods for Least Squares Problems, sections 2.4 (Gram-Schmidt) and 5.3
// (priors as rows).
#include "period/sample_basis.hpp"

#include <cmath>

#include "period/stream/projection.hpp"

namespace toliman::period {

SampleBasis::SampleBasis(const Stream &stream, const Samples &samples, const Column &weights, Real unit)
    : samples_(samples.count), value_offset_(stream.grid().value_offset), weights_(weights) {
    const Projection projection(stream);
    const Basis &basis = stream.grid().basis;
    functions_.resize(projection.used(), Column(samples_, 0));
    for (size_t i = 0; i < samples_; i++) {
        const Sample sample = sample_of(stream, samples, i);
        BasisValues values = {};
        evaluate(basis, stream.grid().time_offset, sample.t_high, sample.t_low, sample.columns, values);
        values.high[0] = 1;
        for (size_t f = 0; f < functions_.size(); f++) {
            const size_t from = projection.index(f);
            functions_[f][i] = static_cast<Real>(values.high[from]) + values.low[from];
        }
    }
    for (size_t f = 0; f < functions_.size(); f++) {
        const size_t from = projection.index(f);
        if (!(basis.precision[from] > 0))
            continue;
        for (Column &function : functions_)
            function.push_back(0);
        functions_[f].back() = std::sqrt(unit * basis.precision[from]) / basis.unit(from);
        if (from == 0) {
            mean_row_ = weights_.size();
            mean_prior_ = functions_[f].back();
        }
        weights_.push_back(1);
    }
    orthonormalise();
}

void SampleBasis::orthonormalise() {
    triangular_.assign(functions_.size(), Column(functions_.size(), 0));
    for (size_t f = 0; f < functions_.size(); f++) {
        Column &function = functions_[f];
        for (int pass = 0; pass < 2; pass++)
            for (size_t j = 0; j < f; j++) {
                const Real part = dot(functions_[j], function);
                triangular_[f][j] += part;
                for (size_t i = 0; i < rows(); i++)
                    function[i] -= part * functions_[j][i];
            }
        const Real norm = std::sqrt(dot(function, function));
        triangular_[f][f] = norm;
        for (Real &element : function)
            element /= norm;
    }
}

SampleBasis::Real SampleBasis::dot(const Column &a, const Column &b) const noexcept {
    Real sum = 0;
    for (size_t i = 0; i < rows(); i++)
        sum += weights_[i] * a[i] * b[i];
    return sum;
}

SampleBasis::Column SampleBasis::values(const Samples &samples, Real mean) const {
    Column values(rows(), 0);
    for (size_t i = 0; i < samples_; i++)
        values[i] = samples.y[i] - mean;
    if (mean_prior_ > 0)
        values[mean_row_] = mean_prior_ * (value_offset_ - mean);
    return values;
}

void SampleBasis::project(Column &x) const noexcept {
    for (int pass = 0; pass < 2; pass++)
        for (const Column &function : functions_) {
            const Real part = dot(function, x);
            for (size_t i = 0; i < rows(); i++)
                x[i] -= part * function[i];
        }
}

SampleBasis::Real SampleBasis::mean_coefficient(const Column &x) const noexcept {
    Real coefficients[kMaxFunctions] = {};
    for (size_t f = used(); f-- > 0;) { // the mean is function 0
        coefficients[f] = dot(functions_[f], x);
        for (size_t later = f + 1; later < used(); later++)
            coefficients[f] -= triangular_[later][f] * coefficients[later];
        coefficients[f] /= triangular_[f][f];
    }
    return coefficients[0];
}

std::vector<double> nuisance_residuals(const Stream &stream, const Samples &samples) {
    SampleBasis::Column weights(samples.count);
    for (size_t i = 0; i < samples.count; i++) {
        const long double sigma = sample_of(stream, samples, i).sigma;
        weights[i] = 1 / (sigma * sigma);
    }
    const SampleBasis basis(stream, samples, weights, 1);
    SampleBasis::Column left = basis.values(samples, 0);
    basis.project(left);
    return {left.begin(), left.begin() + static_cast<std::ptrdiff_t>(samples.count)};
}

} // namespace toliman::period
