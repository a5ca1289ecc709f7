// Method: expected photons of a pixel are
//     m = sum over stars of (1 + flux) S(pixel - place; q) + background,   S = S_0 + sum over k of q_k S_k + ...,
// where S_0 and the derivatives S_k by the parameters q of the optics are planes of the atlas, defocus also with its
// second derivative (masks leave it no first-order effect), and covariances of the jitter are half the second
// derivatives by the place. Between two models, S is interpolated linearly. The detector makes m R + dark electrons of
// them, with variance V. Derivatives by places, fluxes and q are rows of the atlas, too. With J_i = dm/da_i, the Fisher
// matrix and gradient are
//     F_ij = sum over pixels of J_i J_j R^2/V,   g_i = sum of J_i R (electrons - m R - dark)/V,
// accumulated row by row, so that no image of the frame's size is kept. Pixels that saturate are left out.
#include "fit/model.hpp"

#include <algorithm>
#include <cmath>

#include "base/hash.hpp"
#include "kernels/shift.hpp"
#include "optics/derivatives.hpp"
#include "optics/nodes.hpp"
#include "optics/reach.hpp"

namespace toliman::fit {

namespace {

using Kind = Parameter::Kind;

constexpr double kLeastChange = 1e-10;   // of the peak, per unit of a parameter
constexpr double kVarianceFloor = 1e-12; // of the largest expected pixel, as in optics/images.cpp

// Lines of the working memory: of each star the image and its five derivatives by the place, then further planes; then
// those of both stars.
constexpr size_t kPlaceLines = 6;
enum Shared : size_t { image_a, image_b, ones, light, weight, residual, products, predicted_light, first_extra };

// A sum of lines.
class Mix {
  public:
    void add(size_t line, double factor) noexcept {
        if (factor == 0)
            return;
        line_[count_] = line;
        factor_[count_++] = factor;
    }
    void sum(const double *lines, size_t pitch, size_t count, double *out) noexcept {
        for (size_t i = 0; i < count_; i++)
            line_[i] *= pitch;
        double *const sums[] = {out};
        kernels::shift_kernels().sum(lines, line_, factor_, 1, count_, count, sums);
    }

  private:
    size_t line_[kernels::kMostTaps] = {}, count_ = 0;
    double factor_[kernels::kMostTaps] = {};
};

// The light of one star alone.
optics::Light only(optics::Light light, size_t star) {
    std::fill(light.photons[1 - star].begin(), light.photons[1 - star].end(), 0.0);
    return light;
}

// Number of the second derivative by the place that a jitter parameter takes, 0 for other parameters.
size_t place_of(Kind kind) noexcept {
    return kind == Kind::jitter_xx ? 3 : kind == Kind::jitter_xy ? 4 : kind == Kind::jitter_yy ? 5 : 0;
}

bool changes_star(Kind kind, size_t star) noexcept {
    const bool a = kind == Kind::temperature_a || kind == Kind::spectrum_a,
               b = kind == Kind::temperature_b || kind == Kind::spectrum_b;
    return star == 0 ? !b : !a;
}

// Farthest place of either star over the cadence, plus `capture_px`.
optics::Offsets reach_of(const Scene &scene, const optics::Light &light, double capture_px) {
    const optics::Offsets places = optics::farthest_on_orbit(scene, light).offset_px;
    std::array<double, 2> reach = {};
    for (size_t axis = 0; axis < 2; axis++)
        reach[axis] = std::max(std::fabs(places[0][axis]), std::fabs(places[1][axis])) + capture_px +
                      optics::max_signal_px(scene.signal);
    return {reach, reach};
}

// Pixels whose neighbours' charge is not known: of bad pixels, and of the border of the frame.
void leave_out_neighbours(const std::vector<size_t> &bad, size_t rows, size_t cols, Buffer<double> &usable) {
    for (const size_t pixel : bad)
        visit_mixed(pixel, rows, cols, true, [&usable](size_t i) { usable[i] = 0; });
    for (size_t i = 0; i < usable.size(); i++)
        if (i / cols == 0 || i / cols == rows - 1 || i % cols == 0 || i % cols == cols - 1)
            usable[i] = 0;
}

} // namespace

Model::Model(const optics::Simulator &simulator, const std::vector<Parameter> &free, double capture_px,
             unsigned workers, const Progress &progress, Effects effects)
    : rows_(simulator.scene().detector.rows), cols_(simulator.scene().detector.cols), pitch_((cols_ + 7) / 8 * 8),
      response_(rows_ * cols_, 1.0), readout_(simulator.detector().readout()) {
    const Scene &scene = simulator.scene();
    if (simulator.plan().atlas.oversampling == 0)
        fail(Status::unsupported, "%s: {accuracy} = %g: must be at least %g for a fit", scene.source.c_str(),
             scene.accuracy, optics::kRounding);
    const optics::DetectorStages &detector = simulator.detector();
    const Buffer<double> &both = simulator.images().both();
    detector.apply_response(response_.data());
    usable_ = response_;
    bad_ = scene.detector.bad_pixels;
    for (const size_t pixel : scene.detector.bad_pixels)
        usable_[pixel] = 0;
    if (readout_.mixes())
        leave_out_neighbours(scene.detector.bad_pixels, rows_, cols_, usable_);
    double least = *std::max_element(response_.begin(), response_.end());
    for (const double used : usable_)
        least = used > 0 ? std::min(least, used) : least;
    tail_ = kBadPixelTail / least;
    how_ = {detector.e_per_count(),
            detector.bias(),
            detector.dark_e(),
            detector.added_variance_e2(),
            kVarianceFloor * *std::max_element(both.begin(), both.end()),
            detector.saturation_e()};
    for (const Parameter parameter : free) {
        if (const char *const why = optics::why_no_derivative(scene, simulator.plan(), parameter))
            fail(Status::unsupported, "%s: {options->free}: \"%s\": %s", scene.source.c_str(),
                 name_of(parameter).c_str(), why);
        const size_t place = place_of(parameter.kind);
        extras_.push_back({parameter, {0, 0}, {0, 0}, place, parameter.kind == Kind::jitter_xy ? 1 : 0.5});
        if (place != 0)
            orders_ = 3;
    }
    std::vector<optics::Planes> drawn; // with those of A
    atlas_ = std::make_shared<optics::Atlas>(
        scene, simulator.pupil(), simulator.plan(), simulator.light(), reach_of(scene, simulator.light(), capture_px),
        [&](const optics::Plan &plan, const optics::Imager &imager, const optics::Light &light, size_t star) {
            if (star == 0)
                drawn = draw(simulator, plan, imager.with_workers(workers), light, progress);
            return std::move(drawn[star]);
        });
    if (effects == Effects::first_order)
        check_planes(scene);
}

Model::Model(const Model &first, const Model &next, double share) : Model(first) {
    next_ = next.atlas_;
    share_ = share;
}

Model::Model(const Model &frame, const Spread &spread) : Model(frame) {
    if (spread.moves() && !readout_.is_linear())
        fail(Status::unsupported, "{spread}: with detector.nonlinearity_per_e or brighter_fatter_px2_per_e, the sum of "
                                  "frames whose stars move does not tell their charges");
    const SpreadTransfer transfer(spread);
    for (std::shared_ptr<const optics::Atlas> *const atlas : {&atlas_, &next_})
        if (*atlas != nullptr)
            *atlas = std::make_shared<optics::Atlas>(spread.moves() ? (*atlas)->filtered(transfer, spread.frames)
                                                                    : (*atlas)->scaled(spread.frames));
    for (double *const number : {&how_.bias, &how_.dark, &how_.added_variance, &how_.floor, &how_.limit})
        *number *= spread.frames;
    readout_ = readout_.of_frames(spread.frames);
}

// The planes of a parameter are not rounding alone: Zernike polynomials of even order do not change, in first order,
// the image of a pupil with b(-x) = 1 - b(x), that of a spiral mask with odd m and without struts.
void Model::check_planes(const Scene &scene) const {
    for (const Extra &extra : extras_) {
        double change = 0, peak = 0;
        for (size_t star = 0; star < 2; star++) {
            for (const double value : atlas_->plane(star, 0))
                peak = std::max(peak, value);
            for (const double value : atlas_->plane(star, extra.plane[star]))
                change = std::max(change, extra.plane[star] != 0 ? std::fabs(value) : 0);
        }
        if (extra.place == 0 && change < kLeastChange * peak)
            fail(Status::scene, "%s: {options->free}: \"%s\": does not change a frame of this scene in first order",
                 scene.source.c_str(), name_of(extra.parameter).c_str());
    }
}

// Images of both stars at the centre, which have their transforms in common, with the derivatives that these give.
std::vector<optics::StarImages> Model::images(const optics::Simulator &simulator, const optics::Plan &plan,
                                              const optics::Imager &imager, const optics::Light &light,
                                              const Progress &progress) const {
    const auto wants = [this](Kind kind) {
        return std::any_of(extras_.begin(), extras_.end(),
                           [kind](const Extra &extra) { return extra.parameter.kind == kind; });
    };
    const bool shape = wants(Kind::focus) || wants(Kind::scale);
    optics::ImageRequest request = {0, shape ? size_t{1} : 0, shape, wants(Kind::focus)};
    std::vector<optics::Mode> modes;
    for (const Extra &extra : extras_)
        if (optics::is_mode(extra.parameter.kind))
            modes.push_back(optics::mode_of(simulator.scene(), simulator.pupil(), extra.parameter));
    for (const optics::Mode &mode : modes)
        request.modes.push_back(&mode);
    const optics::Light samples = plan.nodes ? optics::project_on_nodes(light, plan.wavelengths) : light;
    return imager.images_of_spectra(samples, {samples.photons[0], samples.photons[1]}, request,
                                    [&](double fraction) { progress.report("model images", fraction); });
}

// The images of both stars and their derivatives; numbers them in extras_.
std::vector<optics::Planes> Model::draw(const optics::Simulator &simulator, const optics::Plan &plan,
                                        const optics::Imager &imager, const optics::Light &light,
                                        const Progress &progress) {
    std::vector<optics::StarImages> stars = images(simulator, plan, imager, light, progress);
    std::vector<optics::Planes> planes(2);
    for (size_t star = 0; star < 2; star++) {
        planes[star].push_back(std::move(stars[star].derivatives[0].image));
        const auto number = [&](Buffer<double> &image) {
            planes[star].push_back(std::move(image));
            return planes[star].size() - 1;
        };
        auto next_mode = stars[star].modes.begin();
        for (Extra &extra : extras_) {
            if (extra.place != 0 || !changes_star(extra.parameter.kind, star))
                continue;
            if (extra.parameter.kind == Kind::scale) {
                extra.plane[star] = number(stars[star].scale);
            } else if (extra.parameter.kind == Kind::focus) {
                extra.plane[star] = number(stars[star].focus);
                extra.curve[star] = number(stars[star].focus_curve);
            } else if (optics::is_mode(extra.parameter.kind)) {
                extra.plane[star] = number(*next_mode++);
            } else {
                extra.plane[star] = number(optics::derivatives(simulator.scene(), simulator.pupil(), plan, imager,
                                                               only(light, star), {extra.parameter})[0]);
            }
        }
    }
    return planes;
}

size_t Model::line_of(size_t star, size_t plane) const noexcept {
    return star * (kPlaceLines + atlas_->planes(0)) + (plane == 0 ? 0 : kPlaceLines - 1 + plane);
}

size_t Model::shared(size_t line) const noexcept {
    return 2 * kPlaceLines + atlas_->planes(0) + atlas_->planes(1) + line;
}

size_t Model::spare() const noexcept {
    return shared(first_extra + extras_.size());
}

Work Model::work() const {
    const size_t n = parameters(), lines = spare() + kPlaceLines;
    Work work;
    work.lines.resize(lines * pitch_);
    work.scratch.resize(std::max(atlas_->scratch_size(), next_ ? next_->scratch_size() : 0));
    work.sums.resize((n + 1) * (n + 1) * kernels::kNormalLanes);
    work.matrix.resize(n * n);
    std::fill_n(work.lines.data() + shared(ones) * pitch_, pitch_, 1.0);
    for (std::vector<double> *const line : {&work.smear, &work.collected})
        line->resize(readout_.smears() ? cols_ : 0);
    std::vector<size_t> columns = {1, 2, line_of(1, 0) + 1, line_of(1, 0) + 2, image(0), image(1), shared(ones)};
    for (size_t k = 0; k < extras_.size(); k++)
        columns.push_back(shared(first_extra + k));
    columns.push_back(shared(residual));
    for (const size_t line : columns)
        work.columns.push_back(work.lines.data() + line * pitch_);
    return work;
}

bool Model::covers(const double *values) const noexcept {
    const auto covered = [values](const optics::Atlas &atlas) {
        return atlas.covers(0, values[x_a], values[y_a]) && atlas.covers(1, values[x_b], values[y_b]);
    };
    return covered(*atlas_) && (next_ == nullptr || covered(*next_));
}

// Without further parameters, the image of a star is the first plane itself.
size_t Model::image(size_t star) const noexcept {
    return extras_.empty() ? line_of(star, 0) : shared(star == 0 ? image_a : image_b);
}

void Model::prepare(const double *values, size_t orders, Places &places) const noexcept {
    for (size_t star = 0; star < 2; star++) {
        const double x = values[2 * star], y = values[2 * star + 1];
        places.first[star] = atlas_->place(star, x, y, orders);
        if (next_ != nullptr)
            places.next[star] = next_->place(star, x, y, orders);
    }
}

// A row of a plane and its derivatives by the star's place.
void Model::read_row(size_t star, size_t plane, const Places &places, size_t r, size_t orders, double *const *out,
                     Work &work) const noexcept {
    atlas_->row(star, plane, places.first[star], r, orders, out, work.scratch.data());
    if (next_ == nullptr)
        return;
    double *other[kPlaceLines];
    for (size_t i = 0; i < kPlaceLines; i++)
        other[i] = work.lines.data() + (spare() + i) * pitch_;
    next_->row(star, plane, places.next[star], r, orders, other, work.scratch.data());
    for (size_t i = 0; i < orders * (orders + 1) / 2; i++)
        for (size_t x = 0; x < cols_; x++)
            out[i][x] += share_ * (other[i][x] - out[i][x]);
}

// Lines of both stars and of the light; with all orders of the places, those of the further parameters, too.
void Model::compute_row(const double *values, const Places &places, size_t orders, size_t r,
                        Work &work) const noexcept {
    double *const lines = work.lines.data();
    const auto line = [&](size_t number) { return lines + number * pitch_; };
    for (size_t star = 0; star < 2; star++) {
        double *out[kPlaceLines];
        for (size_t i = 0; i < kPlaceLines; i++)
            out[i] = line(line_of(star, 0) + i);
        read_row(star, 0, places, r, orders, out, work);
        for (size_t plane = 1; plane < atlas_->planes(star); plane++) {
            out[0] = line(line_of(star, plane));
            read_row(star, plane, places, r, 1, out, work);
        }
        if (extras_.empty())
            continue;
        Mix mix;
        mix.add(line_of(star, 0), 1);
        for (size_t k = 0; k < extras_.size(); k++) {
            const double value = values[always + k];
            const Extra &extra = extras_[k];
            if (extra.place != 0)
                mix.add(line_of(star, 0) + extra.place, extra.factor * value);
            if (extra.plane[star] != 0)
                mix.add(line_of(star, extra.plane[star]), value);
            if (extra.curve[star] != 0)
                mix.add(line_of(star, extra.curve[star]), 0.5 * value * value);
        }
        mix.sum(lines, pitch_, cols_, line(image(star)));
    }
    Mix mix;
    mix.add(image(0), 1 + values[flux_a]);
    mix.add(image(1), 1 + values[flux_b]);
    mix.add(shared(ones), values[background]);
    mix.sum(lines, pitch_, cols_, line(shared(light)));
    if (orders < orders_)
        return;
    for (size_t k = 0; k < extras_.size(); k++) {
        const Extra &extra = extras_[k];
        Mix derivative;
        for (size_t star = 0; star < 2; star++) {
            const double flux = 1 + values[flux_a + star];
            if (extra.place != 0)
                derivative.add(line_of(star, 0) + extra.place, extra.factor * flux);
            if (extra.plane[star] != 0)
                derivative.add(line_of(star, extra.plane[star]), flux);
            if (extra.curve[star] != 0)
                derivative.add(line_of(star, extra.curve[star]), flux * values[always + k]);
        }
        derivative.sum(lines, pitch_, cols_, line(shared(first_extra + k)));
    }
}

// What a row collects: its light, and in photons what it receives from the shift of the frame.
const double *Model::collected(size_t r, Work &work) const noexcept {
    const double *const photons = work.lines.data() + shared(light) * pitch_;
    if (work.smear.empty())
        return photons;
    for (size_t c = 0; c < cols_; c++)
        work.collected[c] = photons[c] + work.smear[c] / response_[r * cols_ + c];
    return work.collected.data();
}

// The expected counts of a row whose light is known.
void Model::counts_of_row(size_t r, const double *photons, double *counts) const noexcept {
    const double *const response = &response_[r * cols_];
    for (size_t i = 0; i < cols_; i++)
        counts[i] = (std::max(0.0, photons[i] * response[i]) + how_.dark) / how_.e_per_count + how_.bias;
}

// Weights and residuals of the counts of a row, or of those expected, whose light is known.
void Model::weigh_row(const ImageView<const double> *counts, size_t r, double blend, Work &work) const {
    double *const lines = work.lines.data(), *const expected = lines + shared(products) * pitch_;
    const double *const photons = collected(r, work);
    if (counts == nullptr)
        counts_of_row(r, photons, expected);
    const double *const given = counts != nullptr ? counts->row(r) : expected;
    if (!kernels::normal_kernels().weigh(given, photons, &usable_[r * cols_], how_, blend, cols_,
                                         lines + shared(weight) * pitch_, lines + shared(residual) * pitch_, &work.used,
                                         &work.saturated))
        refuse(given, r);
    leave_out(r, lines + shared(weight) * pitch_, lines + shared(residual) * pitch_, work);
}

// Takes the bad pixels out of a row, with those that they mix with, as the scene's (leave_out_neighbours).
void Model::leave_out(size_t r, double *weight, double *residual, Work &work) const noexcept {
    for (const size_t bad : work.bad)
        visit_mixed(bad, rows_, cols_, readout_.mixes(), [&](size_t pixel) {
            if (const size_t c = pixel % cols_; pixel / cols_ == r && weight[c] > 0) {
                weight[c] = residual[c] = 0;
                work.used--;
            }
        });
}

void Model::weigh(size_t r, const double *light, double *weight, double *scratch) const noexcept {
    size_t used = 0, saturated = 0;
    counts_of_row(r, light, scratch);
    kernels::normal_kernels().weigh(scratch, light, &usable_[r * cols_], how_, 0, cols_, weight, scratch + cols_, &used,
                                    &saturated);
}

// The shift of the frame is known from the frame itself, so that it is part of no derivative. With light u_i, the
// counts of n pixels of a column sum to the light of these plus n s sum(u); that of bad pixels is the expected one.
// Without counts, all is.
void Model::set_smear(const ImageView<const double> *counts, const double *values, Work &work) const {
    std::fill(work.smear.begin(), work.smear.end(), 0.0);
    std::vector<double> light_sum(cols_), used(cols_);
    std::vector<bool> is_bad(cols_);
    const double *const photons = work.lines.data() + shared(light) * pitch_;
    for (size_t r = 0; r < rows_; r++) {
        const double *const response = &response_[r * cols_];
        is_bad.assign(cols_, counts == nullptr);
        const auto mark = [&](size_t pixel) {
            if (pixel / cols_ == r)
                is_bad[pixel % cols_] = true;
        };
        std::for_each(bad_.begin(), bad_.end(), mark);
        std::for_each(work.bad.begin(), work.bad.end(), mark);
        if (std::find(is_bad.begin(), is_bad.end(), true) != is_bad.end())
            compute_row(values, work.places, orders_, r, work);
        for (size_t c = 0; c < cols_; c++) {
            const bool counted = !is_bad[c];
            light_sum[c] +=
                counted ? (counts->row(r)[c] - how_.bias) * how_.e_per_count - how_.dark : photons[c] * response[c];
            used[c] += counted ? 1 : 0;
        }
    }
    for (size_t c = 0; c < cols_; c++)
        work.smear[c] = readout_.smear() * light_sum[c] / (1 + used[c] * readout_.smear());
}

void Model::begin(const ImageView<const double> *counts, const double *values, Work &work) const {
    prepare(values, orders_, work.places);
    if (readout_.smears())
        set_smear(counts, values, work);
    work.used = work.saturated = 0;
}

void Model::read(double *counts) const {
    if (!has_readout())
        return;
    for (size_t i = 0; i < rows_ * cols_; i++)
        counts[i] = (counts[i] - how_.bias) * how_.e_per_count;
    readout_.read(counts);
    for (size_t i = 0; i < rows_ * cols_; i++)
        counts[i] = counts[i] / how_.e_per_count + how_.bias;
}

Model::Row Model::row(const ImageView<const double> *counts, const double *values, double blend, size_t r,
                      Work &work) const {
    const double *const lines = work.lines.data();
    compute_row(values, work.places, orders_, r, work);
    weigh_row(counts, r, blend, work);
    return {r, lines + shared(weight) * pitch_, lines + shared(residual) * pitch_, lines + shared(light) * pitch_,
            work.columns.data()};
}

void Model::linearise(const ImageView<const double> *counts, const double *values, double blend, Work &work) const {
    const size_t n = parameters();
    std::fill(work.sums.begin(), work.sums.end(), 0.0);
    work.largest = work.excess = 0;
    visit(counts, values, blend, work, [&](const Row &row) {
        kernels::normal_kernels().largest(row.weight, row.residual, tail_, cols_, &work.largest, &work.excess);
        kernels::normal_kernels().add(work.columns.data(), n + 1, row.weight, cols_,
                                      work.lines.data() + shared(products) * pitch_, work.sums.data());
    });
    const auto sum = [&](size_t i, size_t j) {
        return kernels::sum_of_lanes(&work.sums[(i * (n + 1) + j) * kernels::kNormalLanes]);
    };
    for (size_t i = 0; i < n; i++) {
        for (size_t j = i; j < n; j++)
            work.matrix[i * n + j] = scale_of(i, values) * scale_of(j, values) * sum(i, j);
        work.gradient[i] = scale_of(i, values) * sum(i, n);
    }
    work.chi_square = sum(n, n);
    work.inverse_counts = work.matrix[background * n + background];
}

BadPixels::Found Model::find_bad_pixels(const ImageView<const double> &counts, const double *values, double *excess,
                                        Work &work) const {
    double square = 0;
    visit(&counts, values, 0, work, [&](const Row &row) {
        for (size_t c = 0; c < cols_; c++) {
            excess[row.row * cols_ + c] = row.weight[c] * excess_of(row.residual[c], tail_);
            square += row.weight[c] * row.residual[c] * row.residual[c];
        }
    });
    if (work.used <= parameters())
        return BadPixels::Found::too_many;
    const auto freedom = static_cast<double>(work.used - parameters());
    return work.bad.add_largest(rows_ * cols_, square, freedom, [excess](size_t i) { return excess[i]; });
}

void Model::refuse(const double *counts, size_t r) const {
    size_t col = 0;
    while (std::isfinite(counts[col]))
        col++;
    fail(Status::argument, "{counts}[%zu][%zu] = %g: must be finite", r, col, counts[col]);
}

void Model::expect(const double *values, ImageView<double> counts, Work &work) const {
    begin(nullptr, values, work);
    for (size_t r = 0; r < rows_; r++) {
        compute_row(values, work.places, orders_, r, work);
        counts_of_row(r, collected(r, work), counts.row(r));
    }
}

void Model::whiten_derivative(const double *values, const double *coefficients, double *image, Work &work) const {
    const double *const lines = work.lines.data();
    begin(nullptr, values, work);
    for (size_t r = 0; r < rows_; r++) {
        compute_row(values, work.places, orders_, r, work);
        weigh_row(nullptr, r, 0, work);
        double *const out = image + r * cols_;
        const double *const weights = lines + shared(weight) * pitch_;
        for (size_t c = 0; c < cols_; c++) {
            double sum = 0;
            for (size_t i = 0; i < parameters(); i++)
                sum += coefficients[i] * scale_of(i, values) * work.columns[i][c];
            out[c] = std::sqrt(weights[c]) * sum;
        }
    }
}

void Model::whiten_residual(const ImageView<const double> *counts, const double *predicted, const double *values,
                            const double *filter, double *image, double *filtered, Work &work) const {
    const size_t n = parameters(), value_orders = orders_ > 2 ? orders_ : 1; // jitter is a second derivative
    const kernels::NormalKernels &kernel = kernels::normal_kernels();
    double *const lines = work.lines.data();
    const auto line = [&](size_t number) { return lines + shared(number) * pitch_; };
    const bool elsewhere = predicted != values;
    if (elsewhere)
        prepare(predicted, value_orders, work.predicted);
    begin(counts, values, work);
    std::fill(work.sums.begin(), work.sums.end(), 0.0);
    for (size_t r = 0; r < rows_; r++) {
        if (elsewhere) {
            compute_row(predicted, work.predicted, value_orders, r, work);
            std::copy_n(line(light), cols_, line(predicted_light));
        }
        compute_row(values, work.places, orders_, r, work);
        weigh_row(counts, r, 0, work);
        kernel.whiten(line(weight), line(residual), line(light), line(elsewhere ? predicted_light : light), cols_,
                      image + r * cols_);
        kernel.correlate(work.columns.data(), n, line(weight), filter + r * cols_, cols_, line(products),
                         work.sums.data());
    }
    for (size_t i = 0; i <= n; i++)
        filtered[i] = (i < n ? scale_of(i, values) : 1) * kernels::sum_of_lanes(&work.sums[i * kernels::kNormalLanes]);
}

uint64_t Model::digest() const noexcept {
    uint64_t hash = fnv1a(usable_, fnv1a(rows_, fnv1a(cols_, kFnvOffset)));
    for (const double number : {how_.e_per_count, how_.bias, how_.dark, how_.added_variance, how_.floor, how_.limit})
        hash = fnv1a(std::array<double, 1>{number}, hash);
    hash = readout_.digest(hash);
    for (const Extra &extra : extras_)
        hash = fnv1a(static_cast<uint64_t>(extra.parameter.number),
                     fnv1a(static_cast<uint64_t>(extra.parameter.kind), hash));
    for (size_t star = 0; star < 2; star++)
        for (size_t plane = 0; plane < atlas_->planes(star); plane++)
            hash = fnv1a(atlas_->plane(star, plane), hash);
    return hash;
}

} // namespace toliman::fit
