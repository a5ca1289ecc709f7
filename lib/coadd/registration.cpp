// Method: weighted least squares of counts against flux times the image of the stars at (x, y), one linear step from
// the nearest place of the table. With image L, its slopes X, Y and weights w = 1/variance of the expected light,
//     [LL LX LY; LX XX XY; LY XY YY] (df, f dx, f dy) = (Lr, Xr, Yr),   AB = sum over pixels of w A B,
// r the residual of f L. The inverse of the matrix is the covariance; chi-square is rr minus the gain of the step.
// Every frame starts anew, so that its result does not depend on other frames, and sums not on their order:
//   1. flux and centroid of the counts, against those of the model. The centroid errs by 0.05 to 0.1 px;
//   2. steps on every fourth row until the place stays, to 4e-3 px;
//   3. a step on all rows from the nearest place of the table, at most 0.75 steps of the table away;
//   4. pixels beyond the limit of frame/bad_pixels.hpp against the model after the step are left out, with those that
//      saturate or may; where there are some, again from 3, without them, until they stay the same.
// One step about a single place is not enough: pointing that jitters by 0.3 px rms moves fringes by a radian.
// The variance is that of the model, never of the counts, whose correlation with the residual would bias the flux.
#include "coadd/registration.hpp"

#include <algorithm>

#include "base/symmetric.hpp"
#include "frame/bad_pixels.hpp"

namespace toliman::coadd {

namespace {

using namespace kernels;

constexpr size_t kCoarseStep = 4;        // rows
constexpr int kMostCoarse = 8, kMostFine = 6; // steps
constexpr double kStays = 0.75;          // of a step of the table
constexpr double kLeastFlux = 0.2, kMostFlux = 5;
constexpr double kDarkRow = 40; // expected electrons of a row below which it may have no counts: exp(-40)
constexpr double kCentroidRange = 0.5; // px
constexpr double kClip = 1.3; // of the brightest expected count

} // namespace

Registration::Registration(const fit::Fit &fit, const fit::Prediction &prediction, int range, double most_chi_square,
                           unsigned workers, const Progress &progress)
    : table_(fit, prediction, range, workers, progress), rows_(fit.rows()), cols_(fit.cols()),
      most_chi_square_(most_chi_square), pixels_(pixels(fit.model())) {
    calibrate(fit, prediction);
}

// Of all pixels: one number, if they respond equally, otherwise an array.
CoaddPixels Registration::pixels(const fit::Model &model) {
    const Buffer<double> &response = model.usable();
    const CountModel &how = model.counts();
    const bool uniform = std::all_of(response.begin(), response.end(),
                                     [&](double r) { return r == response[0] && r > 0; });
    const size_t count = uniform ? 1 : response.size();
    for (Buffer<float> *const array : {&gain_, &offset_, &spread_, &added_})
        array->resize(count);
    for (size_t i = 0; i < response.size(); i++)
        if (response[i] > 0)
            used_++;
        else
            bad_.push_back(static_cast<uint32_t>(i));
    for (size_t i = 0; i < count; i++) {
        const bool usable = response[i] > 0;
        const double r = usable ? response[i] : 1;
        gain_[i] = static_cast<float>(how.e_per_count / r);
        offset_[i] = static_cast<float>((how.bias * how.e_per_count + how.dark) / r);
        spread_[i] = static_cast<float>(1 / r);
        added_[i] = usable ? static_cast<float>((how.added_variance + how.dark) / (r * r)) : kCoaddUnused;
    }
    base_ = how.bias + how.dark / how.e_per_count;
    const double most = std::ceil(how.limit / how.e_per_count + how.bias);
    return {uniform,
            gain_.data(),
            offset_.data(),
            spread_.data(),
            added_.data(),
            static_cast<float>(std::max(1e-6, how.floor)),
            static_cast<float>(std::min(how.limit - how.dark, 1e30)),
            static_cast<uint16_t>(std::clamp(most, 1.0, double{UINT16_MAX}))};
}

// Total and centroid of expected frames at some places.
void Registration::calibrate(const fit::Fit &fit, const fit::Prediction &prediction) {
    fit::Work model = fit.model().work();
    Buffer<double> expected(rows_ * cols_);
    const fit::Fit::Start start = fit.start_of(prediction);
    double moments[5][3] = {};
    const double shift[5][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    for (size_t k = 0; k < 5; k++) {
        double values[fit::kMostParameters] = {};
        std::copy(std::begin(start.values), std::end(start.values), values);
        for (size_t i = 0; i < 4; i++)
            values[i] += kCentroidRange * shift[k][i % 2];
        fit.model().expect(values, {expected.data(), rows_, cols_, cols_}, model);
        for (const uint32_t pixel : bad_)
            expected[pixel] = base_;
        for (size_t r = 0; r < rows_; r++) {
            double row = 0;
            for (size_t c = 0; c < cols_; c++) {
                const double light = expected[r * cols_ + c] - base_;
                moments[k][0] += light;
                moments[k][1] += light * static_cast<double>(c);
                moments[k][2] += light * static_cast<double>(r);
                row += expected[r * cols_ + c];
            }
            if (k == 0 && row * fit.model().counts().e_per_count < kDarkRow)
                dark_rows_++;
        }
        if (k == 0)
            top_ = static_cast<uint16_t>(
                std::min(kClip * *std::max_element(expected.begin(), expected.end()) + 100, double{UINT16_MAX}));
    }
    total_ = moments[0][0];
    const auto place = [&](size_t k, size_t axis) { return moments[k][1 + axis] / moments[k][0]; };
    double matrix[2][2];
    for (size_t axis = 0; axis < 2; axis++) {
        centre_[axis] = place(0, axis);
        for (size_t along = 0; along < 2; along++)
            matrix[axis][along] = (place(2 + 2 * along, axis) - place(1 + 2 * along, axis)) / (2 * kCentroidRange);
    }
    const double determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
    if (!(total_ > 0) || !(std::fabs(determinant) > 1e-6))
        fail(Status::scene, "{fit}: the light of a frame does not move with the stars");
    inverse_[0][0] = matrix[1][1] / determinant;
    inverse_[0][1] = -matrix[0][1] / determinant;
    inverse_[1][0] = -matrix[1][0] / determinant;
    inverse_[1][1] = matrix[0][0] / determinant;
    double light = 0;
    fit.model().visit(nullptr, start.values, 0, model, [&](const fit::Model::Row &row) {
        for (size_t c = 0; c < cols_; c++)
            light += row.light[c];
    });
    photons_ = light;
}

// Of the counts of used pixels above those without light, in the frame's own pixels.
void Registration::centroid(const CoaddFrame &frame, Work &work, double *moments, size_t *zero_rows) const noexcept {
    uint64_t sums[3];
    coadd_kernels().centroid(frame, top_, work.columns.data(), sums, zero_rows);
    const double pixels = static_cast<double>(rows_ * cols_);
    moments[0] = static_cast<double>(sums[0]) - base_ * pixels;
    moments[1] = static_cast<double>(sums[1]) - base_ * pixels * 0.5 * static_cast<double>(cols_ - 1);
    moments[2] = static_cast<double>(sums[2]) - base_ * pixels * 0.5 * static_cast<double>(rows_ - 1);
    for (const uint32_t pixel : bad_) {
        const size_t r = pixel / cols_, c = pixel % cols_;
        const double counts = std::min(frame.counts[r * frame.stride + c], top_) - base_;
        moments[0] -= counts;
        moments[1] -= counts * static_cast<double>(c);
        moments[2] -= counts * static_cast<double>(r);
    }
}

Registration::Estimate Registration::start(const CoaddFrame &frame, Work &work, size_t *zero_rows) const noexcept {
    double moments[3];
    centroid(frame, work, moments, zero_rows);
    const double x = moments[1] / moments[0] - centre_[0], y = moments[2] / moments[0] - centre_[1];
    return {moments[0] / total_, inverse_[0][0] * x + inverse_[0][1] * y, inverse_[1][0] * x + inverse_[1][1] * y};
}

// One step about a place of the table, on every `step`-th row.
Registration::Solution Registration::solve(const CoaddFrame &frame, const Cell &cell, double flux, size_t step,
                                           const Registered *left_out) const noexcept {
    const CoaddModel model = table_.model(cell);
    double sums[kCoaddSums];
    coadd_kernels().accumulate(frame, model, pixels_, static_cast<float>(flux), step, sums);
    for (size_t i = 0; left_out != nullptr && i < left_out->left_out; i++) {
        const size_t r = left_out->pixels[i] / cols_, c = left_out->pixels[i] % cols_, m = r * model.stride + c,
                     p = pixels_.uniform ? 0 : left_out->pixels[i];
        const double light = static_cast<double>(model.light_scale) * model.light[m],
                     x = static_cast<double>(model.slope_scale) * model.slope_x[m],
                     y = static_cast<double>(model.slope_scale) * model.slope_y[m], expected = flux * light;
        const double weight = 1 / (std::max(expected, double{pixels_.least}) * double{pixels_.spread[p]} +
                                   double{pixels_.added[p]});
        const double residual = frame.counts[r * frame.stride + c] * double{pixels_.gain[p]} -
                                double{pixels_.offset[p]} - expected;
        const double image[3] = {light, x, y};
        sums[sum_ll] -= weight * light * light;
        sums[sum_lx] -= weight * light * x;
        sums[sum_ly] -= weight * light * y;
        sums[sum_xx] -= weight * x * x;
        sums[sum_xy] -= weight * x * y;
        sums[sum_yy] -= weight * y * y;
        for (size_t k = 0; k < 3; k++)
            sums[sum_lr + k] -= weight * image[k] * residual;
        sums[sum_rr] -= weight * residual * residual;
    }
    Solution out = {};
    double matrix[9] = {sums[sum_ll], sums[sum_lx], sums[sum_ly], sums[sum_lx], sums[sum_xx],
                        sums[sum_xy], sums[sum_ly], sums[sum_xy], sums[sum_yy]};
    out.found = invert_symmetric(matrix, 3);
    if (!out.found)
        return out;
    double change[3] = {};
    out.chi_square = sums[sum_rr];
    for (size_t i = 0; i < 3; i++) {
        for (size_t j = 0; j < 3; j++) {
            out.covariance[i][j] = matrix[3 * i + j];
            change[i] += matrix[3 * i + j] * sums[sum_lr + j];
        }
        out.chi_square -= change[i] * sums[sum_lr + i];
    }
    out.step = {change[0], change[1], change[2]};
    return out;
}

// Moves to the stars; false if the steps do not end there.
bool Registration::approach(const CoaddFrame &frame, Estimate &at) const noexcept {
    for (int i = 0; i < kMostCoarse; i++) {
        const Cell cell = Table::nearest(at.x, at.y);
        if (!table_.covers(cell))
            return false;
        const Solution solution = solve(frame, cell, at.flux, kCoarseStep, nullptr);
        const double flux = at.flux + solution.step.flux;
        if (!solution.found || !(flux > kLeastFlux && flux < kMostFlux))
            return false;
        const double dx = solution.step.x / flux, dy = solution.step.y / flux;
        const double most = 0.5, length = std::hypot(dx, dy), share = length > most ? most / length : 1;
        at = {flux, Table::place(cell.x) + share * dx, Table::place(cell.y) + share * dy};
        if (std::max(std::fabs(dx), std::fabs(dy)) * kSteps < 2 * kStays)
            return true;
    }
    return false;
}

// Steps on all rows, and tests, until the pixels that are left out stay the same.
bool Registration::finish(const CoaddFrame &frame, Estimate &at, Registered &out) const noexcept {
    out.left_out = 0;
    for (int i = 0; i < kMostFine; i++) {
        const Cell cell = Table::nearest(at.x, at.y);
        if (!table_.covers(cell))
            return false;
        const Solution solution = solve(frame, cell, at.flux, 1, &out);
        const double flux = at.flux + solution.step.flux;
        if (!solution.found || !(flux > kLeastFlux && flux < kMostFlux))
            return false;
        const CoaddStep step = {static_cast<float>(flux), static_cast<float>(solution.step.x),
                                static_cast<float>(solution.step.y)};
        const double dx = solution.step.x / flux, dy = solution.step.y / flux;
        at = {flux, Table::place(cell.x) + dx, Table::place(cell.y) + dy};
        if (!(std::max(std::fabs(dx), std::fabs(dy)) * kSteps < kStays))
            continue;
        std::array<uint32_t, kMostLeftOut> found;
        const CoaddModel model = table_.model(cell);
        const size_t count = coadd_kernels().test(frame, model, pixels_, step, static_cast<float>(kBadPixelLimit),
                                                  found.data(), found.size());
        if (count > kMostLeftOut) {
            out.verdict = Verdict::misfit;
            return false;
        }
        const bool same = count == out.left_out && std::equal(found.begin(), found.begin() + count, out.pixels.begin());
        out.left_out = count;
        std::copy_n(found.begin(), count, out.pixels.begin());
        if (!same && i + 1 < kMostFine)
            continue;
        out.flux = flux;
        out.x = at.x;
        out.y = at.y;
        out.xx = solution.covariance[1][1] / (flux * flux);
        out.xy = solution.covariance[1][2] / (flux * flux);
        out.yy = solution.covariance[2][2] / (flux * flux);
        out.chi_square = solution.chi_square / (static_cast<double>(used_ - count) - 3);
        out.saturated = 0;
        for (size_t k = 0; k < count; k++) {
            const size_t r = found[k] / cols_, c = found[k] % cols_, m = r * model.stride + c,
                         p = pixels_.uniform ? 0 : found[k];
            const float light = step.flux * model.light_scale * static_cast<float>(model.light[m]) +
                                model.slope_scale * (step.x * static_cast<float>(model.slope_x[m]) +
                                                     step.y * static_cast<float>(model.slope_y[m]));
            out.expected[k] = (std::max(light, 0.0f) + pixels_.offset[p]) / pixels_.gain[p];
            out.saturated += frame.counts[r * frame.stride + c] >= pixels_.most ? 1 : 0;
        }
        return true;
    }
    return false;
}

void Registration::frame(const CoaddFrame &frame, Work &work, Registered &out) const noexcept {
    size_t zero_rows;
    Estimate at = start(frame, work, &zero_rows);
    out.verdict = Verdict::added;
    out.left_out = out.saturated = 0;
    out.flux = at.flux;
    out.x = at.x;
    out.y = at.y;
    out.chi_square = 0;
    if (zero_rows > dark_rows_) {
        out.verdict = Verdict::lost;
        return;
    }
    if (!(at.flux > kLeastFlux && at.flux < kMostFlux)) {
        out.verdict = Verdict::faint;
        return;
    }
    out.verdict = Verdict::not_found;
    at.x = std::clamp(at.x, -table_.range(), table_.range());
    at.y = std::clamp(at.y, -table_.range(), table_.range());
    if (!approach(frame, at) || !finish(frame, at, out)) {
        if (out.verdict == Verdict::not_found && !table_.covers(Table::nearest(at.x, at.y)))
            out.verdict = Verdict::outside;
        out.left_out = out.saturated = 0;
        return;
    }
    out.verdict = out.chi_square <= most_chi_square_ ? Verdict::added : Verdict::misfit;
}

} // namespace toliman::coadd
