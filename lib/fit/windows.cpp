// Method: at time t in window i, which starts at t_i, the model is
//     (1 - w) m_i + w m_(i+1),   w = (t - t_i)/(t_(i+1) - t_i),
// with m_i the model of scene i. Images, derivatives and predicted places are continuous in time: a model that changed
// in steps at the starts of windows would put the period of the steps into the separations.
#include "fit/windows.hpp"

#include <algorithm>
#include <array>

#include "base/hash.hpp"

namespace toliman::fit {

namespace {

bool same(const sky::Orbit &a, const sky::Orbit &b) noexcept {
    return a.period_years == b.period_years && a.semi_major_arcsec == b.semi_major_arcsec &&
           a.eccentricity == b.eccentricity && a.inclination_deg == b.inclination_deg && a.node_deg == b.node_deg &&
           a.periastron_deg == b.periastron_deg && a.epoch == b.epoch;
}

bool same(const Binary &a, const Binary &b) noexcept {
    return a.centre == b.centre && a.separation_arcsec == b.separation_arcsec &&
           a.position_angle_deg == b.position_angle_deg && a.date == b.date && a.moving == b.moving &&
           a.by_offsets == b.by_offsets &&
           std::equal(std::begin(a.offsets_px), std::end(a.offsets_px), std::begin(b.offsets_px)) &&
           a.orbit.has_value() == b.orbit.has_value() && (!a.orbit || same(*a.orbit, *b.orbit)) &&
           (a.sky == nullptr) == (b.sky == nullptr) && (!a.sky || a.sky->digest() == b.sky->digest());
}

bool same(const Cadence &a, const Cadence &b) noexcept {
    return a.frames == b.frames && a.interval_days == b.interval_days && a.times_days == b.times_days;
}

// The places of the stars are means over these with an observer.
bool same_exposure(const Scene &a, const Scene &b) noexcept {
    return a.binary.sky == nullptr ||
           (a.cadence.exposure_s == b.cadence.exposure_s && a.cadence.on_target_s == b.cadence.on_target_s &&
            a.cadence.windows == b.cadence.windows);
}

void check_same(const Scene &first, const Scene &other, size_t window) {
    const char *const what = first.detector.rows != other.detector.rows || first.detector.cols != other.detector.cols
                                 ? "detector.shape"
                             : !same(first.binary, other.binary)                                   ? "binary"
                             : !same(first.cadence, other.cadence) || !same_exposure(first, other) ? "cadence"
                                                                                                   : nullptr;
    if (what != nullptr)
        fail(Status::mismatch, "{sims[%zu]}: %s: %s: must be that of %s", window, other.source.c_str(), what,
             first.source.c_str());
}

// The progress of one window as a part of that of all.
struct Part {
    const Progress &all;
    size_t window, count;
    static int32_t call(const char *stage, double fraction, void *data) {
        const Part &part = *static_cast<const Part *>(data);
        return part.all.asks_to_stop(stage,
                                     (static_cast<double>(part.window) + fraction) / static_cast<double>(part.count))
                   ? 1
                   : 0;
    }
};

} // namespace

Windows::Windows(const std::vector<const optics::Simulator *> &simulators, const double *first_days,
                 const std::vector<Parameter> &free, double capture_px, unsigned workers, const Progress &progress)
    : first_days_(first_days, first_days + simulators.size()) {
    for (size_t i = 1; i < simulators.size(); i++)
        check_same(simulators[0]->scene(), simulators[i]->scene(), i);
    for (size_t i = 0; i < simulators.size(); i++) {
        Part part = {progress, i, simulators.size()};
        fits_.push_back(std::make_shared<Fit>(*simulators[i], free, capture_px, workers, Progress{Part::call, &part}));
    }
}

std::shared_ptr<const Fit> Windows::at(double days) const {
    const auto later = std::upper_bound(first_days_.begin() + 1, first_days_.end(), days);
    const size_t next = static_cast<size_t>(later - first_days_.begin()), i = next - 1;
    if (next == fits_.size() || days <= first_days_[i])
        return fits_[i];
    const double share = (days - first_days_[i]) / (first_days_[next] - first_days_[i]);
    return std::make_shared<Fit>(*fits_[i], *fits_[next], share);
}

std::shared_ptr<const Fit> Windows::at(const Prediction &prediction) const {
    return of_sum(at(prediction.days), prediction.spread);
}

// The lines of the work depend on the parameters, which are the same; its scratch memory depends on the atlas.
FitWork Windows::work() const {
    const auto largest = std::max_element(fits_.begin(), fits_.end(), [](const auto &a, const auto &b) {
        return a->model().atlas().scratch_size() < b->model().atlas().scratch_size();
    });
    return (*largest)->work();
}

size_t Windows::images() const noexcept {
    size_t images = 0;
    for (const auto &fit : fits_)
        images += fit->model().atlas().planes(0) + fit->model().atlas().planes(1);
    return images;
}

uint64_t Windows::digest() const noexcept {
    uint64_t hash = first().digest();
    for (size_t i = 1; i < fits_.size(); i++)
        hash = fnv1a(fits_[i]->digest(), fnv1a(std::array<double, 2>{first_days_[i - 1], first_days_[i]}, hash));
    return hash;
}

} // namespace toliman::fit
