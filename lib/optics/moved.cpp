// Method: the light of a star at the place x of the frame is its image, of relative flux f,
//     f S(pixel - x),
// interpolated from the atlas; a star outside it, beyond 4 sigma of the systematics, is propagated at its place. The
// place holds the whole motion, so that all products with a shift are exact.
//     Frames whose optics differ are propagated each: with the pupil's OPD plus the frame's Zernike polynomials, focus
// among them, and pixels that are smaller by 1 + scale. An expansion about the scene's optics was rejected: a second
// order in focus was wrong by 2 % of the effect at 1 nm, products of several polynomials are as many as their squares,
// and a mask may leave the image no first order of them.
#include "optics/moved.hpp"

#include <algorithm>

namespace toliman::optics {

const Atlas &MovedStars::atlas() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!atlas_) {
        const MemoryScope scope(memory_);
        const auto draw = [](const Plan &, const Imager &imager, const Light &light, size_t star) {
            StarImages images = imager.images(light, star, 0, ImageRequest());
            Planes planes;
            planes.push_back(std::move(images.derivatives[0].image));
            return planes;
        };
        atlas_ = std::make_unique<Atlas>(scene_, pupil_, plan_, light_, plan_.atlas.reach, draw);
    }
    return *atlas_;
}

const std::vector<Mode> &MovedStars::modes() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (modes_.empty()) {
        const MemoryScope scope(memory_);
        for (const ZernikeDisturbance &zernike : scene_.systematics.zernikes_nm)
            modes_.push_back(zernike_mode(pupil_, zernike.noll));
    }
    return modes_;
}

// The padded FFT makes its pupils from the scene.
MovedStars::Instrument MovedStars::instrument_of(const Disturbances &disturbances) const {
    Instrument instrument = {scene_, pupil_, plan_};
    std::vector<ZernikeTerm> &terms = instrument.scene.telescope.zernikes;
    terms.insert(terms.end(), disturbances.zernikes.begin(), disturbances.zernikes.end());
    const std::vector<Mode> &modes = this->modes();
    Buffer<double> &opd = instrument.pupil.opd_m;
    for (size_t mode = 0; mode < modes.size(); mode++)
        for (size_t i = 0; i < opd.size(); i++)
            opd[i] += disturbances.zernikes[mode].rms_m * 1e9 * modes[mode].opd_m[i];
    instrument.plan.pixels.pitch_rad /= 1 + static_cast<long double>(disturbances.scale);
    return instrument;
}

void MovedStars::add_interpolated(size_t star, const Place &place, double flux, double *image) const {
    const Atlas &known = atlas();
    const Atlas::Place among = known.place(star, place[0], place[1], 1);
    const size_t cols = known.cols();
    Buffer<double> row(cols), scratch(known.scratch_size());
    double *const out = row.data();
    for (size_t r = 0; r < plan_.pixels.rows; r++) {
        known.row(star, 0, among, r, 1, &out, scratch.data());
        for (size_t i = 0; i < cols; i++)
            image[r * cols + i] += flux * row[i];
    }
}

void MovedStars::add_propagated(const Imager &imager, Light light, size_t star, const Place &place, double flux,
                                double *image) const {
    for (size_t i = 0; i < 2; i++)
        light.offset_px[star][i] = static_cast<double>(place[i]);
    const StarImages images = imager.images(light, star, 0, ImageRequest());
    const Buffer<double> &own = images.at(0, 0);
    for (size_t i = 0; i < own.size(); i++)
        image[i] += flux * own[i];
}

void MovedStars::expect(double displacement_px, const Disturbances &disturbances, double days, double *image) const {
    const Offsets offsets = offsets_at(scene_, light_, days);
    const auto axis = axis_of(scene_, offsets);
    const double relative_light = relative_light_at(scene_, days);
    const size_t pixels = plan_.pixels.rows * plan_.pixels.cols;
    std::fill_n(image, pixels, disturbances.background_photons);
    std::optional<Instrument> own;
    if (scene_.systematics.changes_optics())
        own = instrument_of(disturbances);
    const Imager imager = own ? Imager(own->scene, own->pupil, own->plan, 1) : imager_.with_workers(1);
    Light light = light_;
    for (double &by_wavelength : light.dispersion)
        by_wavelength *= 1 + disturbances.scale;
    for (size_t star = 0; star < scene_.stars.size(); star++) {
        const double wobble = star == scene_.signal.star ? displacement_px : 0,
                     flux = relative_light * (1 + disturbances.flux[star]);
        const Place place = place_of(disturbances, offsets[star], axis.data(), wobble);
        const bool interpolated = plan_.frames == Frames::atlas && atlas().covers(star, place[0], place[1]);
        if (interpolated)
            add_interpolated(star, place, flux, image);
        else
            add_propagated(imager, light, star, place, flux, image);
    }
    detector_.collect(image);
    for (size_t i = 0; i < pixels; i++)
        image[i] = std::max(0.0, image[i] + detector_.dark_e());
}

} // namespace toliman::optics
