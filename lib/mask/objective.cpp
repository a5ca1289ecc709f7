// Method: with the derivative images J_i of the frame by the separation (i = 0) and the free nuisances, its variance V
// and the Fisher matrix F_ij = sum over pixels of J_i J_j / V, the squared bound is s^2 = x_0 with F x = e_0. Since
// d(s^2) = -x^T dF x, only the image r = sum_i x_i J_i is needed:
//     d ln s = 1/s^2 sum over pixels of (-(r/V) sum_i x_i dJ_i + r^2/(2 V^2) dV).
// Each J_i is a combination of the stars' images and their derivatives by position and focus, whose weights follow; one
// adjoint transform per wavelength and star turns these into the gradient by every cell (optics/gradient.hpp).
// In a scene that gives the peak, photons are in inverse proportion to the brightest pixel. Its place jumps, so that
// the maximum is replaced by the norm of order kOrder, which is above it by at most a few per cent. Penalties are
// squares of logarithms, which begin smoothly at the limit. Tested against central differences of the loss
// (tests/kernel/test_objective.c). Reference: Wong et al. 2021, J. Opt. Soc. Am. B 38, 2465 (design by automatic
// differentiation of a Fisher matrix).
#include "mask/objective.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/symmetric.hpp"
#include "base/workers.hpp"
#include "information/information.hpp"

namespace toliman::mask {

namespace {

using Kind = Parameter::Kind;

constexpr double kOrder = 64;    // of the norm that replaces the maximum
constexpr double kMaximum = 0;   // stands for the maximum itself
constexpr double kFloor = 1e-12; // of the variance, relative to the peak

optics::Settings settings_of(unsigned workers) {
    optics::Settings settings;
    settings.workers = workers;
    return settings;
}

bool is_known(Kind kind) noexcept {
    for (const Kind known : {Kind::flux_a, Kind::flux_b, Kind::shift_x, Kind::shift_y, Kind::roll, Kind::scale,
                             Kind::focus, Kind::background})
        if (kind == known)
            return true;
    return false;
}

double sum_of(const Buffer<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

} // namespace

Objective::Objective(const Scene &scene, const std::vector<Parameter> &free, double step_m, unsigned workers)
    : outline_([&] {
          Scene clear = scene;
          clear.telescope.mask = {};
          clear.projected.clear();
          return optics::outline_of(std::move(clear), settings_of(workers));
      }()),
      free_(free), imager_(outline_.scene, outline_.pupil, outline_.plan, worker_count(workers)),
      detector_(outline_.scene) {
    for (const Parameter &parameter : free)
        if (!is_known(parameter.kind) || (parameter.kind == Kind::flux_b && scene.stars.size() < 2))
            fail(Status::unsupported, "%s: a mask cannot be designed with %s free", scene.source.c_str(),
                 name_of(parameter).c_str());
    if (outline_.plan.engine != optics::EngineKind::matrix_dft)
        fail(Status::unsupported, "%s: the engine PADDED_FFT models no mask: use MATRIX_DFT", scene.source.c_str());
    optics::Pupil &pupil = outline_.pupil;
    plain_opd_m_ = pupil.opd_m;
    pupil.step_m = step_m;
    for (size_t i = 0; i < pupil.amplitude.size(); i++)
        if (pupil.amplitude[i] > 0)
            pupil.mixed.push_back({i, 0});
    response_.assign(outline_.plan.pixels.rows * outline_.plan.pixels.cols, 1.0);
    detector_.apply_response(response_.data());
    for (const std::vector<double> &star : outline_.light.photons)
        photons_ += std::accumulate(star.begin(), star.end(), 0.0);
}

void Objective::set_mask(const Buffer<double> &covered) {
    optics::Pupil &pupil = outline_.pupil;
    for (optics::MixedCell &cell : pupil.mixed) {
        cell.covered = covered[cell.index];
        pupil.opd_m[cell.index] = plain_opd_m_[cell.index] + cell.covered * pupil.step_m;
    }
}

// The stars' images and derivatives, in photons as in a frame. order: of the norm of the peak.
void Objective::render(double order, Work &work) const {
    const size_t stars = outline_.scene.stars.size();
    work.light.assign(response_.size(), 0.0);
    for (size_t s = 0; s < stars; s++) {
        work.star[s] = imager_.images(outline_.light, s, 0, {1, 1, true, false});
        const Buffer<double> &image = work.star[s].at(0, 0);
        for (size_t i = 0; i < image.size(); i++)
            work.light[i] += image[i];
    }
    if (outline_.scene.cadence.peak_photons == 0)
        return;
    const double peak = *std::max_element(work.light.begin(), work.light.end());
    double sum = 0;
    for (const double value : work.light)
        sum += order == kMaximum ? 0 : std::pow(std::max(value, 0.0) / peak, order);
    const double norm = order == kMaximum ? 1 : std::pow(sum, 1 / order);
    work.factor = outline_.scene.cadence.peak_photons / (peak * norm);
}

// Derivative images, variance, and the solution of the normal equations.
void Objective::inform(const std::vector<Parameter> &free, Work &work) const {
    const optics::Light &light = outline_.light;
    const size_t n = work.light.size(), stars = outline_.scene.stars.size(), cols = outline_.plan.pixels.cols;
    const double x_axis = light.axis[0], y_axis = light.axis[1];
    const double x_middle = 0.5 * static_cast<double>(cols - 1),
                 y_middle = 0.5 * static_cast<double>(outline_.plan.pixels.rows - 1);
    std::vector<Parameter> parameters = {{Kind::separation}};
    parameters.insert(parameters.end(), free.begin(), free.end());
    work.columns.resize(parameters.size());
    for (Buffer<double> &column : work.columns)
        column.resize(n);
    const double peak = *std::max_element(work.light.begin(), work.light.end());
    work.variance.resize(n);
    double slopes = 0, light_e = 0;
    for (size_t i = 0; i < n; i++) {
        work.variance[i] = work.factor * response_[i] * (work.light[i] + kFloor * peak) + detector_.dark_e() +
                           detector_.added_variance_e2();
        const size_t row = i / cols, col = i % cols;
        const double u = static_cast<double>(col) - x_middle, v = static_cast<double>(row) - y_middle;
        double x = 0, y = 0, roll = 0, focus = 0;
        for (size_t s = 0; s < stars; s++) {
            const double along = work.star[s].at(1, 0)[i], across = work.star[s].at(0, 1)[i];
            const double by_x = x_axis * along - y_axis * across, by_y = y_axis * along + x_axis * across;
            x += by_x;
            y += by_y;
            roll += light.offset_px[s][0] * by_y - light.offset_px[s][1] * by_x;
            focus += work.star[s].focus[i];
        }
        slopes += response_[i] * response_[i] * (x * x + y * y);
        light_e += response_[i] * work.light[i];
        for (size_t k = 0; k < parameters.size(); k++) {
            double value = 0;
            switch (parameters[k].kind) {
            case Kind::separation:
                value = work.star[outline_.scene.signal.star].at(1, 0)[i];
                break;
            case Kind::flux_a:
                value = work.star[0].at(0, 0)[i];
                break;
            case Kind::flux_b:
                value = work.star[1].at(0, 0)[i];
                break;
            case Kind::shift_x:
                value = x;
                break;
            case Kind::shift_y:
                value = y;
                break;
            case Kind::roll:
                value = roll;
                break;
            case Kind::scale:
                value = u * x + v * y - 2 * work.light[i];
                break;
            case Kind::focus:
                value = focus;
                break;
            default:
                value = 1 / work.factor; // background
            }
            work.columns[k][i] = work.factor * response_[i] * value;
        }
    }
    for (const size_t pixel : outline_.scene.detector.bad_pixels)
        work.variance[pixel] = std::numeric_limits<double>::infinity();
    work.gradient_energy = slopes / light_e / light_e * static_cast<double>(n);
    const size_t count = parameters.size();
    std::vector<double> matrix(count * count);
    for (size_t a = 0; a < count; a++)
        for (size_t b = a; b < count; b++) {
            double sum = 0;
            for (size_t i = 0; i < n; i++)
                sum += work.columns[a][i] * work.columns[b][i] / work.variance[i];
            matrix[a * count + b] = sum;
        }
    work.solution.clear();
    if (invert_symmetric(matrix.data(), count))
        work.solution.assign(matrix.begin(), matrix.begin() + static_cast<std::ptrdiff_t>(count));
}

// Loss, and its derivatives by the score's image and by the light.
void Objective::weigh(const Limit &limit, Work &work, Merit &merit) const {
    const size_t n = work.light.size();
    const double total = sum_of(work.light), square = work.solution[0];
    const double peak = *std::max_element(work.light.begin(), work.light.end());
    const double threshold = limit.peak_to_mean * total / limit.frame_pixels;
    work.score.resize(n);
    work.by_light.resize(n);
    double by_factor = 0, by_total = 0, penalty = 0; // derivatives of the loss by ln(factor) and by the total light
    for (size_t i = 0; i < n; i++) {
        double r = 0;
        for (size_t k = 0; k < work.columns.size(); k++)
            r += work.solution[k] * work.columns[k][i];
        work.score[i] = -r / (work.variance[i] * square);
        work.by_light[i] = 0.5 * square * work.score[i] * work.score[i] * work.factor * response_[i];
        by_factor += work.score[i] * r + work.by_light[i] * work.light[i];
        const double excess = limit.peak_weight > 0 ? std::log(std::max(work.light[i], kFloor * peak) / threshold) : 0;
        if (excess > 0) {
            penalty += limit.peak_weight * excess * excess;
            by_total -= limit.peak_weight * 2 * excess / total;
            work.by_light[i] += limit.peak_weight * 2 * excess / work.light[i];
        }
    }
    for (size_t k = 0; k < free_.size(); k++) // the background does not vary with the factor
        if (free_[k].kind == Kind::background)
            for (size_t i = 0; i < n; i++)
                by_factor -= work.score[i] * work.solution[k + 1] * work.columns[k + 1][i];
    const double lack = limit.light_weight > 0 ? std::log(limit.light_in_frame * photons_ / total) : 0;
    if (lack > 0) {
        penalty += limit.light_weight * lack * lack;
        by_total -= limit.light_weight * 2 * lack / total;
    }
    const bool by_peak = outline_.scene.cadence.peak_photons > 0;
    double norm = 0;
    for (size_t i = 0; by_peak && i < n; i++)
        norm += std::pow(std::max(work.light[i], 0.0) / peak, kOrder);
    for (size_t i = 0; i < n; i++) {
        work.by_light[i] += by_total;
        if (by_peak && work.light[i] > 0)
            work.by_light[i] -= by_factor * std::pow(work.light[i] / peak, kOrder) / (norm * work.light[i]);
    }
    merit.bound_px = std::sqrt(square);
    merit.loss = 0.5 * std::log(square) + penalty;
    merit.peak_to_mean = peak / total * limit.frame_pixels;
    merit.light_in_frame = total / photons_;
}

Buffer<double> Objective::gradient_of(const Work &work) const {
    const optics::Light &light = outline_.light;
    const size_t n = work.light.size(), stars = outline_.scene.stars.size(), cols = outline_.plan.pixels.cols;
    const double x_middle = 0.5 * static_cast<double>(cols - 1),
                 y_middle = 0.5 * static_cast<double>(outline_.plan.pixels.rows - 1);
    Buffer<double> gradient(outline_.pupil.amplitude.size());
    for (size_t s = 0; s < stars; s++) {
        double by_flux = 0, by_x = 0, by_y = 0, by_scale = 0, by_focus = 0;
        const double own = s == outline_.scene.signal.star ? work.solution[0] : 0;
        for (size_t k = 0; k < free_.size(); k++) {
            const double x = work.solution[k + 1];
            const Kind kind = free_[k].kind;
            by_flux += kind == (s == 0 ? Kind::flux_a : Kind::flux_b) ? x : 0;
            by_x += kind == Kind::shift_x ? x : kind == Kind::roll ? -light.offset_px[s][1] * x : 0;
            by_y += kind == Kind::shift_y ? x : kind == Kind::roll ? light.offset_px[s][0] * x : 0;
            by_scale += kind == Kind::scale ? x : 0;
            by_focus += kind == Kind::focus ? x : 0;
        }
        Buffer<double> image(n), along(n), across(n), focus(n);
        for (size_t i = 0; i < n; i++) {
            const double score = work.score[i] * work.factor * response_[i];
            const size_t row = i / cols, col = i % cols;
            const double u = static_cast<double>(col) - x_middle, v = static_cast<double>(row) - y_middle;
            const double x = by_x + u * by_scale, y = by_y + v * by_scale;
            image[i] = work.by_light[i] + score * (by_flux - 2 * by_scale);
            along[i] = score * (own + light.axis[0] * x + light.axis[1] * y);
            across[i] = score * (light.axis[0] * y - light.axis[1] * x);
            focus[i] = score * by_focus;
        }
        const Buffer<double> cells = imager_.coverage_gradient(light, s, image, along, across, focus);
        for (size_t m = 0; m < cells.size(); m++)
            gradient[outline_.pupil.mixed[m].index] += cells[m];
    }
    return gradient;
}

Merit Objective::evaluate(const Buffer<double> &covered, const Limit &limit, Buffer<double> *gradient) {
    set_mask(covered);
    render(kOrder, work_);
    inform(free_, work_);
    Merit merit;
    merit.loss = merit.bound_px = Score::kNone;
    if (work_.solution.empty())
        return merit;
    weigh(limit, work_, merit);
    if (gradient != nullptr)
        *gradient = gradient_of(work_);
    return merit;
}

// Of the images that were rendered last.
double Objective::bound_with(const std::vector<Parameter> &free) {
    inform(free, work_);
    return work_.solution.empty() ? Score::kNone : std::sqrt(work_.solution[0]);
}

Score Objective::judge(const Buffer<double> &covered, double frame_pixels) {
    set_mask(covered);
    render(kMaximum, work_);
    const double light = sum_of(work_.light);
    const double electrons = work_.factor * sum_of(response_) / static_cast<double>(response_.size());
    const Quantum quantum = quantum_of(outline_, electrons);
    Score score;
    score.alone_px = bound_with({});
    score.flux_shift_px = bound_with(information::fluxes_and_shift(outline_.scene));
    score.crb_px = bound_with(free_);
    score.peak_to_mean = *std::max_element(work_.light.begin(), work_.light.end()) / light * frame_pixels;
    score.light_in_frame = light / photons_;
    score.gradient_energy = work_.gradient_energy;
    score.radius_50_px = encircled_px(work_.light, outline_.plan.pixels.cols, 0.5);
    score.radius_80_px = encircled_px(work_.light, outline_.plan.pixels.cols, 0.8);
    score.quantum_px = quantum.alone_px;
    score.quantum_flux_shift_px = quantum.flux_shift_px;
    return score;
}

} // namespace toliman::mask
