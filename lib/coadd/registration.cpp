// Method: weighted least squares of counts against flux times the image of the stars at (x, y), one linear step from
// the nearest place of the table. With image L, its slopes X, Y and weights w = 1/variance of the expected light,
//     [LL LX LY; LX XX XY; LY XY YY] (df, f dx, f dy) = (Lr, Xr, Yr),   AB = sum over pixels of w A B,
// r the residual of f L. The inverse of the matrix is the covariance; chi-square is rr minus the gain of the step.
// Every frame starts again, so that its result does not depend on other frames, and sums not on their order:
//   1. steps on every eighth row with images that are blurred by 0.7 px, at whole pixels: their fringes are washed out,
//      so that steps converge from 1 px. What a step is without displacement, and its gain, come from expected frames;
//   2. steps on these rows with the table, until the place stays, to 1e-2 px;
//   3. a step on all rows from the nearest place of the table, at most 0.75 steps of the table away;
//   4. pixels beyond the limit of frame/bad_pixels.hpp against the model after the step are left out, with those that
//      saturate or may; where there are some, again from 3, without them, until they stay the same.
// A frame that does not fit then is tried again, first with images blurred by 2 px, which lead from 4 px, and with
// other rows: a bright cosmic ray may have led 1 or 2 astray.
// One step about a single place is not enough: pointing that jitters by 0.3 px rms moves fringes by a radian. A start
// from the centroid of the counts fails where light moves out of the frame: it is off by 0.5 px in frames of 64 x 64.
// The variance is that of the model, never of the counts, whose correlation with the residual would bias the flux.
#include "coadd/registration.hpp"

#include <algorithm>

#include "base/symmetric.hpp"
#include "frame/bad_pixels.hpp"

namespace toliman::coadd {

namespace {

using namespace kernels;

constexpr size_t kCoarse = 8, kLeastRows = 8;   // every eighth row, if these are so many
constexpr int kSteps = 8;                       // of the table, per pixel
constexpr double kNearBlur = 0.7, kFarBlur = 2; // px
constexpr int kMostSteps = 8;
constexpr size_t kAttempts = 4;
constexpr double kStays = 0.75; // of a step of the table
constexpr double kFarSigmas = 7;
constexpr double kLeastFlux = 0.2, kMostFlux = 5;
constexpr double kDarkRow = 40;  // expected electrons of a row below which it may have no counts: exp(-40)
constexpr double kMoved = 0.7;   // of the blur, of the frames that calibrate steps
constexpr double kLongest = 0.5; // px, of a step of the table

// Whether a pixel of so much light is so far below the limit that saturated counts are always bad pixels.
bool is_far(double photons, double limit, double added) noexcept {
    const double margin = limit - photons;
    return margin > 0 && margin * margin > kFarSigmas * kFarSigmas * (photons + added + margin);
}

fit::Fit blurred(const fit::Fit &fit, double blur) {
    Spread spread;
    spread.xx = spread.yy = blur * blur;
    return fit::Fit(fit, spread);
}

} // namespace

Registration::Registration(const fit::Fit &fit, const fit::Prediction &prediction, int range, double most_chi_square,
                           unsigned workers, const Progress &progress)
    : table_(fit, prediction, range, kSteps, workers, progress), rows_(fit.rows()), cols_(fit.cols()),
      most_chi_square_(most_chi_square), pixels_(pixels(fit.model(), kMostFlux * table_.most_photons())),
      near_(make_coarse(fit, prediction, range, kNearBlur, workers)),
      far_(make_coarse(fit, prediction, range, kFarBlur, workers)) {
    expect(fit, prediction);
}

// Of all pixels: one number, if they respond equally, otherwise an array.
CoaddPixels Registration::pixels(const fit::Model &model, double most_photons) {
    const Buffer<double> &response = model.usable();
    const CountModel &how = model.counts();
    const bool uniform =
        std::all_of(response.begin(), response.end(), [&](double r) { return r == response[0] && r > 0; });
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
    const double most = std::ceil(how.limit / how.e_per_count + how.bias);
    return {uniform,
            gain_.data(),
            offset_.data(),
            spread_.data(),
            added_.data(),
            static_cast<float>(std::max(1e-6, how.floor)),
            static_cast<float>(std::min(how.limit - how.dark, 1e30)),
            static_cast<uint16_t>(std::clamp(most, 1.0, double{UINT16_MAX})),
            is_far(most_photons, how.limit - how.dark, how.added_variance + how.dark)};
}

// Gain of steps: of expected frames where the stars are, and moved.
Registration::Coarse Registration::make_coarse(const fit::Fit &fit, const fit::Prediction &prediction, int range,
                                               double blur, unsigned workers) const {
    Coarse made = {Table(blurred(fit, blur), prediction, range, 1, workers, Progress()), {}, {}};
    fit::Work model = fit.model().work();
    Buffer<double> expected(rows_ * cols_);
    Buffer<uint16_t> counts(rows_ * cols_);
    const fit::Fit::Start start = fit.start_of(prediction);
    const double moved = kMoved * blur, moves[5][2] = {{0, 0}, {-moved, 0}, {moved, 0}, {0, -moved}, {0, moved}};
    double steps[5][2];
    for (size_t k = 0; k < 5; k++) {
        double values[fit::kMostParameters] = {};
        std::copy(std::begin(start.values), std::end(start.values), values);
        for (size_t i = 0; i < 4; i++)
            values[i] += moves[k][i % 2];
        fit.model().expect(values, {expected.data(), rows_, cols_, cols_}, model);
        for (size_t i = 0; i < counts.size(); i++)
            counts[i] = static_cast<uint16_t>(std::clamp(std::nearbyint(expected[i]), 0.0, double{UINT16_MAX}));
        const Solution step = solve({counts.data(), cols_, rows_, cols_}, made.table, {0, 0}, 1, {}, nullptr);
        steps[k][0] = step.step.x;
        steps[k][1] = step.step.y;
    }
    double gain[2][2];
    for (size_t axis = 0; axis < 2; axis++) {
        made.zero[axis] = steps[0][axis];
        for (size_t along = 0; along < 2; along++)
            gain[axis][along] = (steps[2 + 2 * along][axis] - steps[1 + 2 * along][axis]) / (2 * moved);
    }
    const double determinant = gain[0][0] * gain[1][1] - gain[0][1] * gain[1][0];
    if (!(determinant > 0.01))
        fail(Status::scene, "{fit}: the light of a frame does not move with the stars");
    made.inverse[0][0] = gain[1][1] / determinant;
    made.inverse[0][1] = -gain[0][1] / determinant;
    made.inverse[1][0] = -gain[1][0] / determinant;
    made.inverse[1][1] = gain[0][0] / determinant;
    return made;
}

// What a frame at the predicted place has: light, and rows without counts.
void Registration::expect(const fit::Fit &fit, const fit::Prediction &prediction) {
    fit::Work work = fit.model().work();
    const CountModel &how = fit.model().counts();
    fit.model().visit(nullptr, fit.start_of(prediction).values, 0, work, [&](const fit::Model::Row &row) {
        double electrons = 0;
        for (size_t c = 0; c < cols_; c++) {
            const double response = fit.model().usable()[row.row * cols_ + c];
            photons_ += row.light[c];
            electrons += how.bias * how.e_per_count + how.dark + response * std::fmax(0, row.light[c]);
        }
        dark_rows_ += electrons < kDarkRow ? 1 : 0;
    });
}

// One step about a place of a table, without the pixels that are left out.
Registration::Solution Registration::solve(const CoaddFrame &frame, const Table &table, const Cell &cell, double flux,
                                           Rows rows, const Registered *left_out) const noexcept {
    const CoaddModel model = table.model(cell);
    double sums[kCoaddSums];
    coadd_kernels().accumulate(frame, model, pixels_, static_cast<float>(flux), rows.start, rows.step, sums);
    for (size_t i = 0; left_out != nullptr && i < left_out->left_out; i++) {
        const size_t r = left_out->pixels[i] / cols_, c = left_out->pixels[i] % cols_, m = r * model.stride + c,
                     p = pixels_.uniform ? 0 : left_out->pixels[i];
        const double light = static_cast<double>(model.light_scale) * model.light[m],
                     x = static_cast<double>(model.slope_scale) * model.slope_x[m],
                     y = static_cast<double>(model.slope_scale) * model.slope_y[m], expected = flux * light;
        const double weight =
            1 / (std::max(expected, double{pixels_.least}) * double{pixels_.spread[p]} + double{pixels_.added[p]});
        const double residual =
            frame.counts[r * frame.stride + c] * double{pixels_.gain[p]} - double{pixels_.offset[p]} - expected;
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

// Moves to the stars as far as blurred images lead; false if they do not.
bool Registration::start(const CoaddFrame &frame, Rows rows, const Coarse &coarse, Estimate &at) const noexcept {
    Cell cell = coarse.table.nearest(at.x, at.y);
    for (int i = 0; i < kMostSteps; i++) {
        const Solution solution = solve(frame, coarse.table, cell, at.flux, rows, nullptr);
        at.flux = std::fmax(kLeastFlux, at.flux + solution.step.flux);
        if (!solution.found || !(at.flux < kMostFlux))
            return false;
        const double x = solution.step.x / at.flux - coarse.zero[0], y = solution.step.y / at.flux - coarse.zero[1];
        const double dx = coarse.inverse[0][0] * x + coarse.inverse[0][1] * y,
                     dy = coarse.inverse[1][0] * x + coarse.inverse[1][1] * y;
        at.x = std::clamp(cell.x + std::clamp(dx, -kFarBlur, kFarBlur), -table_.range(), table_.range());
        at.y = std::clamp(cell.y + std::clamp(dy, -kFarBlur, kFarBlur), -table_.range(), table_.range());
        const Cell next = coarse.table.nearest(at.x, at.y);
        if (std::max(std::fabs(dx), std::fabs(dy)) < kStays || next == cell)
            break;
        cell = next;
    }
    return true;
}

// Moves to the stars; false if the steps do not end there.
bool Registration::approach(const CoaddFrame &frame, Rows rows, Estimate &at) const noexcept {
    for (int i = 0; i < kMostSteps; i++) {
        const Cell cell = table_.nearest(at.x, at.y);
        if (!table_.covers(cell))
            return false;
        const Solution solution = solve(frame, table_, cell, at.flux, rows, nullptr);
        const double flux = at.flux + solution.step.flux;
        if (!solution.found || !(flux > kLeastFlux && flux < kMostFlux))
            return false;
        const double dx = solution.step.x / flux, dy = solution.step.y / flux;
        at = {flux, table_.place(cell.x) + std::clamp(dx, -kLongest, kLongest),
              table_.place(cell.y) + std::clamp(dy, -kLongest, kLongest)};
        if (std::max(std::fabs(dx), std::fabs(dy)) * kSteps < 2 * kStays)
            return true;
    }
    return false;
}

// Steps on all rows, and tests, until the pixels that are left out stay the same.
bool Registration::finish(const CoaddFrame &frame, Estimate &at, Registered &out) const noexcept {
    out.left_out = 0;
    for (int i = 0; i < kMostSteps; i++) {
        const Cell cell = table_.nearest(at.x, at.y);
        if (!table_.covers(cell))
            return false;
        const Solution solution = solve(frame, table_, cell, at.flux, {}, &out);
        const double flux = at.flux + solution.step.flux;
        if (!solution.found || !(flux > kLeastFlux && flux < kMostFlux))
            return false;
        const CoaddStep step = {static_cast<float>(flux), static_cast<float>(solution.step.x),
                                static_cast<float>(solution.step.y)};
        const double dx = solution.step.x / flux, dy = solution.step.y / flux;
        at = {flux, table_.place(cell.x) + dx, table_.place(cell.y) + dy};
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
        if (!same && i + 1 < kMostSteps)
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

// is_far: the stars may be farther than 1 px from their predicted places.
void Registration::attempt(const CoaddFrame &frame, Rows rows, bool is_far, Registered &out) const noexcept {
    Estimate at = {1, 0, 0};
    out.verdict = Verdict::not_found;
    if ((!is_far || start(frame, rows, far_, at)) && start(frame, rows, near_, at) && approach(frame, rows, at) &&
        finish(frame, at, out)) {
        out.verdict = out.chi_square <= most_chi_square_ ? Verdict::added : Verdict::misfit;
        return;
    }
    out.left_out = out.saturated = 0;
    if (!(at.flux > kLeastFlux && at.flux < kMostFlux))
        out.verdict = Verdict::faint;
    else if (!table_.covers(table_.nearest(at.x, at.y)))
        out.verdict = Verdict::outside;
}

void Registration::frame(const CoaddFrame &frame, Registered &out) const noexcept {
    out = {};
    if (coadd_kernels().zero_rows(frame) > dark_rows_) {
        out.verdict = Verdict::lost;
        return;
    }
    const size_t step = std::clamp(rows_ / kLeastRows, size_t{1}, kCoarse);
    for (size_t i = 0; i < kAttempts; i++) {
        attempt(frame, {(step / 2 + i) % step, step}, i > 0, out);
        if (out.verdict == Verdict::added)
            return;
    }
}

} // namespace toliman::coadd
