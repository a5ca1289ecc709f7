// Method: the image of a star about its own place depends on the parameters of the instrument in the same way for all
// places, so that one set of derivative images (planes) serves all frames. Both stars pass the same optics: their
// images have each wavelength's transform in common, and differ in the weights of the wavelengths only. For sums of
// frames they have the mean spread of all: residuals have that of each, so that the estimate has no bias.
// Accuracy: 1e-4 of the peak, with fewer wavelengths and shorter interpolation than the model images. Steps are
// computed with these derivatives, but from residuals of the accurate model. An error of 1e-4 of the derivatives
// changes the estimate by 1e-4 of its standard deviation, and the covariance by as much.
#include "calibrate/planes.hpp"

#include <algorithm>
#include <cmath>

#include "optics/derivatives.hpp"
#include "optics/half_band.hpp"
#include "optics/nodes.hpp"
#include "optics/reach.hpp"

namespace toliman::calibrate {

namespace {

using Kind = Parameter::Kind;

constexpr double kAccuracy = 1e-4;      // of the planes
constexpr double kHalfBandShare = 0.25; // of it, for their interpolation
constexpr size_t kModesAtOnce = 8;      // of one propagation, which holds their fields and images

size_t place_of(Kind kind) noexcept {
    return kind == Kind::jitter_xx || kind == Kind::diffusion ? 3
           : kind == Kind::jitter_xy                          ? 4
           : kind == Kind::jitter_yy                          ? 5
                                                              : 0;
}

bool is_of_pupil(Kind kind) noexcept {
    return kind == Kind::focus || optics::is_mode(kind);
}

// The image that a parameter of the geometry takes; nullptr for others.
Buffer<double> *geometry_of(Kind kind, optics::StarImages &images) noexcept {
    return kind == Kind::scale        ? &images.scale
           : kind == Kind::anisotropy ? &images.anisotropy
           : kind == Kind::shear      ? &images.shear
                                      : nullptr;
}

optics::Plan plan_of(const optics::Outline &outline) {
    Scene rough = outline.scene;
    rough.accuracy = std::max(rough.accuracy, (1 - kHalfBandShare) * kAccuracy);
    optics::Plan plan =
        optics::make_plan(rough, outline.pupil, outline.light, outline.plan.engine, outline.plan.workers);
    if (plan.engine == optics::EngineKind::matrix_dft)
        plan.atlas.half_band = optics::make_half_band(plan.atlas.cutoff, kHalfBandShare * kAccuracy);
    return plan;
}

// Farthest place of either star over the cadence, plus `capture_px`.
std::array<double, 2> reach_of(const optics::Outline &outline, double capture_px) {
    const optics::Offsets places = optics::farthest_on_orbit(outline.scene, outline.light).offset_px;
    std::array<double, 2> reach = {};
    for (size_t axis = 0; axis < 2; axis++)
        reach[axis] = std::max(std::fabs(places[0][axis]), std::fabs(places[1][axis])) + capture_px;
    return reach;
}

} // namespace

Planes::Planes(const optics::Outline &outline, const std::vector<Parameter> &parameters, double capture_px,
               const Spread &spread, uint64_t key, const Progress &progress)
    : key_(key), plan_(plan_of(outline)), reach_(reach_of(outline, capture_px)) {
    for (const Parameter parameter : parameters) {
        const size_t place = place_of(parameter.kind);
        entries_.push_back({parameter,
                            {0, 0},
                            {place, parameter.kind == Kind::diffusion ? size_t{5} : 0},
                            parameter.kind == Kind::jitter_xy ? 1 : 0.5});
        orders_ = place != 0 ? 3 : orders_;
        if (optics::Readout::has(parameter.kind) && detector_ == nullptr)
            detector_ = std::make_unique<optics::DetectorStages>(outline.scene);
    }
    if (detector_ != nullptr) {
        response_.assign(outline.plan.pixels.rows * outline.plan.pixels.cols, 1.0);
        detector_->apply_response(response_.data());
    }
    std::vector<optics::Planes> both; // drawn with those of A
    atlas_ = std::make_unique<optics::Atlas>(
        outline.scene, outline.pupil, plan_, outline.light, optics::Offsets{reach_, reach_},
        [&](const optics::Plan &plan, const optics::Imager &imager, const optics::Light &light, size_t star) {
            if (star == 0)
                both = draw(outline, plan, imager, light, progress);
            return std::move(both[star]);
        });
    if (spread.moves())
        *atlas_ = atlas_->filtered(fit::SpreadTransfer(spread), 1);
}

void Planes::take(size_t entry, size_t star, Buffer<double> &image, optics::Planes &planes) {
    entries_[entry].plane[star] = planes.size();
    planes.push_back(std::move(image));
}

std::vector<optics::Planes> Planes::draw(const optics::Outline &outline, const optics::Plan &plan,
                                         const optics::Imager &imager, const optics::Light &light,
                                         const Progress &progress) {
    const bool has_modes = std::any_of(entries_.begin(), entries_.end(), [](const Entry &entry) {
        return entry.parameter.kind == Kind::spectrum_a || entry.parameter.kind == Kind::spectrum_b;
    });
    const size_t count = plan.wavelengths + (has_modes ? kSpectralModes : 0); // they shift Chebyshev moments
    const auto on_nodes = [&](const optics::Light &all) {
        return plan.nodes && count < all.wavelength_m.size() ? optics::project_on_nodes(all, count) : all;
    };
    const optics::Light samples = on_nodes(light);
    const std::vector<std::vector<double>> spectra = {samples.photons[0], samples.photons[1]};
    std::vector<optics::Planes> planes(2);
    std::vector<size_t> modes, of_geometry, of_spectrum; // numbers of the entries
    for (size_t i = 0; i < entries_.size(); i++) {
        const Kind kind = entries_[i].parameter.kind;
        if (is_of_pupil(kind))
            modes.push_back(i);
        else if (optics::star_of_spectrum(kind) < 2)
            of_spectrum.push_back(i);
        else if (entries_[i].place[0] == 0 && !optics::Readout::has(kind))
            of_geometry.push_back(i);
    }
    optics::ImageRequest request;
    request.plane = of_geometry.empty() ? 0 : 1;
    request.focus = request.geometry = !of_geometry.empty();
    for (size_t first = 0; first == 0 || first < modes.size(); first += kModesAtOnce) {
        const size_t together = std::min(kModesAtOnce, modes.size() - first);
        if (!modes.empty())
            progress.report("derivatives", static_cast<double>(first) / static_cast<double>(modes.size()));
        std::vector<optics::Mode> changes;
        for (size_t i = 0; i < together; i++)
            changes.push_back(optics::mode_of(outline.scene, outline.pupil, entries_[modes[first + i]].parameter));
        request.modes.clear();
        for (const optics::Mode &change : changes)
            request.modes.push_back(&change);
        std::vector<optics::StarImages> images = imager.images_of_spectra(samples, spectra, request);
        for (size_t star = 0; star < 2; star++) {
            if (first == 0) {
                planes[star].push_back(std::move(images[star].derivatives[0].image));
                for (const size_t i : of_geometry)
                    take(i, star, *geometry_of(entries_[i].parameter.kind, images[star]), planes[star]);
            }
            for (size_t i = 0; i < together; i++)
                take(modes[first + i], star, images[star].modes[i], planes[star]);
        }
        request.plane = 0;
        request.focus = request.geometry = false;
    }
    if (of_spectrum.empty())
        return planes;
    std::vector<std::vector<double>> changed;
    for (const size_t i : of_spectrum) {
        const Parameter parameter = entries_[i].parameter;
        changed.push_back(on_nodes(optics::changed_spectrum(outline.scene, light, parameter))
                              .photons[optics::star_of_spectrum(parameter.kind)]);
    }
    std::vector<optics::StarImages> images = imager.images_of_spectra(samples, changed, {});
    for (size_t i = 0; i < of_spectrum.size(); i++) {
        const size_t star = optics::star_of_spectrum(entries_[of_spectrum[i]].parameter.kind);
        take(of_spectrum[i], star, images[i].derivatives[0].image, planes[star]);
    }
    return planes;
}

bool Planes::covers(const double *values) const noexcept {
    return atlas_->covers(0, values[0], values[1]) && atlas_->covers(1, values[2], values[3]);
}

// The expected charges of one frame.
Buffer<double> Planes::charge(const double *values, const Places &places, double *scratch) const {
    const size_t cols = atlas_->cols(), rows = response_.size() / cols;
    Buffer<double> charge(rows * cols, values[6]);
    double *line = scratch, *const work = scratch + kPlaceLines * cols;
    for (size_t star = 0; star < 2; star++)
        for (size_t r = 0; r < rows; r++) {
            atlas_->row(star, 0, places.star[star], r, 1, &line, work);
            for (size_t x = 0; x < cols; x++)
                charge[r * cols + x] += (1 + values[4 + star]) * line[x];
        }
    detector_->collect(charge);
    for (double &value : charge)
        value += detector_->dark_e();
    return charge;
}

void Planes::place(const double *values, Places &places, double *scratch) const {
    for (size_t star = 0; star < 2; star++)
        places.star[star] = atlas_->place(star, values[2 * star], values[2 * star + 1], orders_);
    places.readout.clear();
    if (detector_ == nullptr)
        return;
    const Buffer<double> at = charge(values, places, scratch);
    for (const Entry &entry : entries_)
        if (optics::Readout::has(entry.parameter.kind)) {
            places.readout.push_back(detector_->readout().derivative(entry.parameter.kind, at, detector_->dark_e()));
            for (size_t i = 0; i < response_.size(); i++) // charges to photons
                places.readout.back()[i] /= response_[i];
        }
}

void Planes::row(const double *values, const Places &places, size_t r, double *const *lines,
                 double *scratch) const noexcept {
    const size_t cols = atlas_->cols();
    double *const of_place = scratch, *const work = scratch + kPlaceLines * cols;
    size_t of_readout = 0;
    for (size_t i = 0; i < entries_.size(); i++)
        if (optics::Readout::has(entries_[i].parameter.kind))
            std::copy_n(&places.readout[of_readout++][r * cols], cols, lines[i]);
        else
            std::fill_n(lines[i], cols, 0.0);
    for (size_t star = 0; star < 2; star++) {
        const double flux = 1 + values[4 + star];
        double *out[kPlaceLines];
        for (size_t i = 0; i < kPlaceLines; i++)
            out[i] = of_place + i * cols;
        if (orders_ > 1)
            atlas_->row(star, 0, places.star[star], r, orders_, out, work);
        const auto add = [&](size_t i, double factor, const double *from) {
            for (size_t x = 0; x < cols; x++)
                lines[i][x] += factor * from[x];
        };
        for (size_t i = 0; i < entries_.size(); i++) {
            const Entry &entry = entries_[i];
            for (const size_t place : entry.place)
                if (place != 0)
                    add(i, flux * entry.factor, of_place + place * cols);
        }
        for (size_t i = 0; i < entries_.size(); i++) {
            if (entries_[i].plane[star] == 0)
                continue;
            double *first = of_place;
            atlas_->row(star, entries_[i].plane[star], places.star[star], r, 1, &first, work);
            add(i, flux, first);
        }
    }
}

} // namespace toliman::calibrate
