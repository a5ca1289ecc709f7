#include <cmath>

#include "backend/file.hpp"
#include "base/constants.hpp"
#include "frame/npy_image.hpp"
#include "scene/groups.hpp"
#include "scene/noll.hpp"

namespace toliman::scene {

namespace {

constexpr double kMostResponse = 10;

void read_shape(const Reader &reader, const Row &row, Detector &detector) {
    const std::vector<double> shape = reader.numbers(row);
    if (shape[0] != std::floor(shape[0]) || shape[1] != std::floor(shape[1]))
        reader.refuse(Status::scene, row.key, " = [%g, %g]: must be whole numbers", shape[0], shape[1]);
    detector.rows = static_cast<size_t>(shape[0]);
    detector.cols = static_cast<size_t>(shape[1]);
}

void read_window(const Reader &reader, const Row &row, Detector &detector) {
    const std::vector<double> place = reader.numbers(row);
    if (place[0] != std::floor(place[0]) || place[1] != std::floor(place[1]))
        reader.refuse(Status::scene, row.key, " = [%g, %g]: must be whole numbers", place[0], place[1]);
    detector.window = DetectorWindow{static_cast<int64_t>(place[0]), static_cast<int64_t>(place[1])};
}

constexpr Range kPixelScale = within(1e-6, 100, "arcsec");

void read_pixel(const Reader &reader, const Row &row, Detector &detector) {
    const double pixel_um = reader.number(row);
    detector.pixel_scale_arcsec = pixel_um * 1e-6 / detector.focal_length_m * (180 * 3600 / kPi);
    if (!(detector.pixel_scale_arcsec >= kPixelScale.low && detector.pixel_scale_arcsec <= kPixelScale.high))
        reader.refuse(Status::scene, row.key,
                      " = %g: with focal_length_m = %g, gives %g arcsec: must be in [%g, %g] arcsec", pixel_um,
                      detector.focal_length_m, detector.pixel_scale_arcsec, kPixelScale.low, kPixelScale.high);
}

void read_diffusion(const Reader &reader, const Row &row, Detector &detector) {
    const double sigma = reader.number(row);
    detector.diffusion_px2 = sigma * sigma;
}

void read_qe(const Reader &reader, const Row &row, Detector &detector) {
    if (reader.has_text(row.key))
        detector.qe_file = reader.file(row.key);
    else
        detector.qe = reader.number(row);
    const std::vector<Star> &stars = reader.scene().stars;
    for (size_t star = 0; star < stars.size(); star++)
        if (stars[star].detected)
            reader.refuse(
                Status::scene, row.key,
                ": not allowed with stars.%c.detected_per_s, which are electrons: the quantum efficiency would "
                "count twice",
                star == 0 ? 'A' : 'B');
}

void check_dark(const Reader &reader, const Detector &detector) {
    if (detector.dark_e_per_s > 0 && reader.scene().cadence.exposure_s == 0)
        reader.refuse(Status::scene, "dark_e_per_s", " = %g: needs cadence.exposure_s", detector.dark_e_per_s);
}

// A file with a value of each pixel.
NpyImage read_pixels(const Reader &reader, const char *key, const std::string &path, const Detector &detector) {
    NpyImage image = parse_npy(file::read(path, detector.rows * detector.cols * sizeof(double) + 65536), path);
    if (image.rows != detector.rows || image.cols != detector.cols)
        reader.refuse(Status::scene, key, ": %s is %zu x %zu: must be %zu x %zu, as shape", path.c_str(), image.rows,
                      image.cols, detector.rows, detector.cols);
    return image;
}

void read_response(const Reader &reader, Detector &detector) {
    const std::string &path = detector.response_file;
    const NpyImage image = read_pixels(reader, "response", path, detector);
    for (size_t i = 0; i < image.values.size(); i++)
        if (!(image.values[i] > 0 && image.values[i] <= kMostResponse))
            fail(Status::format, "{%s}: element [%zu][%zu] = %g: must be in (0, %g], 1 for the mean response",
                 path.c_str(), i / image.cols, i % image.cols, image.values[i], kMostResponse);
    detector.response.assign(image.values.begin(), image.values.end());
}

void read_bad_pixels(const Reader &reader, Detector &detector) {
    const std::string &path = detector.bad_pixels_file;
    const size_t pixels = detector.rows * detector.cols;
    const NpyImage image = read_pixels(reader, "bad_pixels", path, detector);
    for (size_t i = 0; i < pixels; i++) {
        if (!std::isfinite(image.values[i]))
            fail(Status::format,
                 "{%s}: element [%zu][%zu] = %g: must be 0 for a good pixel, another number for a bad one",
                 path.c_str(), i / image.cols, i % image.cols, image.values[i]);
        if (image.values[i] != 0)
            detector.bad_pixels.push_back(i);
    }
    if (detector.bad_pixels.size() == pixels)
        reader.refuse(Status::scene, "bad_pixels", ": %s: all %zu pixels are bad", path.c_str(), pixels);
}

constexpr Row kSidelobeRows[] = {
    required<&Sidelobe::period_m>("period_um", above(0, 1e6, "um"), "Period of the grating; TOLIMAN: 300").scaled(1e-6),
    required<&Sidelobe::angle_deg>("angle_deg", kTurn,
                                   "Direction of the order, from +x (higher columns) towards +y (higher rows)"),
    required<&Sidelobe::centre_m>(
        "centre_nm", above(0, 1e5, "nm"),
        "Wavelength whose order, of a star on the optical axis, is at the centre of the frame")
        .scaled(1e-9),
    optional<&Sidelobe::efficiency>("efficiency", above(0, 1),
                                    "Share of the light in this order; of peak_photons, all is in it"),
};
constexpr Group kSidelobe = group_of("sidelobe",
                                     "The frames are a window around the first order of a grating in the pupil, which "
                                     "displaces light by wavelength/period: the spectrum in it relates the plate scale "
                                     "to wavelengths",
                                     kSidelobeRows);

constexpr Row kDetectorRows[] = {
    required<read_shape>("shape", within(1, 2048, "px"), "Rows and columns").as(Type::integers).entries(2, 2),
    required<&Detector::pixel_scale_arcsec>("pixel_scale_arcsec", kPixelScale, "Side of a pixel on the sky")
        .either("focal_length_m"),
    optional<&Detector::focal_length_m>("focal_length_m", above(0, 1e6, "m"),
                                        "Effective focal length; with pixel_um, instead of pixel_scale_arcsec"),
    required<read_pixel>("pixel_um", above(0, 1e6, "um"),
                         "Side of a pixel; pixel_scale_arcsec is pixel_um/focal_length_m, from rad to arcsec")
        .when(with("focal_length_m", "needs focal_length_m")),
    optional<&Detector::integrated>(
        "pixel", Words{"point integrated"},
        "Sampling; point: the image at the pixel's centre; integrated: its mean over the pixel"),
    optional<&Detector::scale_anisotropy>("scale_anisotropy", within(-0.1, 0.1),
                                          "Relative difference of the scales in x and y: an angle (u, v) in units of "
                                          "pixel_scale_arcsec, u and v along the pupil's axes, is at the pixels x = "
                                          "(1 + scale_anisotropy) u, y = shear u + (1 - scale_anisotropy) v"),
    optional<&Detector::shear>("shear", within(-0.1, 0.1),
                               "Tilt of the rows: pixels in y per unit of u; see "
                               "scale_anisotropy"),
    optional<&Detector::rotation_deg>("rotation_deg", kTurn, "Position angle of the +y axis"),
    optional<read_qe>(
        "qe", above(0, 1),
        "Quantum efficiency, electrons per photon: a number, or a file with wavelength and qe, which must "
        "cover the band and be above 0 in it. peak_photons are photons before a number, electrons with a "
        "file; 1 if not given")
        .as(Type::number_or_file),
    optional<&Detector::coadds>("coadds", within(1, 1e9, "frames"),
                                "Frames summed on board; read variance and full well apply to each; exposure_s is that "
                                "of the sum"),
    optional<&Detector::flat_rms>("flat_rms", within(0, 0.1), // keeps responses above 0
                                  "Pixel response non-uniformity, relative rms; a fixed pattern of noise.seed"),
    optional<read_diffusion>("diffusion_px", within(0, 10, "px"),
                             "Diffusion of charge before it is collected: a Gaussian blur, standard deviation"),
    optional<&Detector::transfer_smear>(
        "transfer_smear", within(-0.1, 0.1),
        "Light that a pixel receives while the frame is shifted to its store, as a share "
        "of the sum of its column: time of one row over the exposure"),
    optional<&Detector::brighter_fatter_px2_per_e>(
        "brighter_fatter_px2_per_e", within(-1, 1, "px^2 per e-"),
        "Brighter-fatter effect: charge flows to neighbours as in a blur of this variance times the pixel's mean "
        "charge, in each of the coadds"),
    optional<&Detector::interpixel_capacitance>(
        "interpixel_capacitance", within(-0.05, 0.05),
        "Share of a pixel's charge, with its noise, that each of its four neighbours measures instead of it"),
    optional<&Detector::nonlinearity_per_e>(
        "nonlinearity_per_e", within(-1, 1, "per e-"),
        "A charge c of each of the coadds is measured as c - nonlinearity_per_e c^2"),
    optional<&Detector::response_file>("response",
                                       "Relative response of each pixel, times qe and flat_rms: .npy of the frames' "
                                       "shape, in (0, 10], such as calibrate --detector writes; that of the frames' "
                                       "pixels at window, without which fits refuse frames that name one, other than "
                                       "[0, 0]")
        .checked<read_response>(),
    optional<&Detector::dark_e_per_s>("dark_e_per_s", within(0, 1e9, "e-/s"),
                                      "Dark current per pixel; needs cadence.exposure_s")
        .checked<check_dark>(),
    optional<&Detector::full_well_e>("full_well_e", within(1, 1e12, "e-"),
                                     "Full well of a pixel in each of the coadds; unlimited if not given"),
    optional<&Detector::gain_e_per_dn>("gain_e_per_dn", within(1e-6, 1e12, "e- per DN"), "Gain"),
    optional<&Detector::bias_dn>("bias_dn", within(0, 4294967295, "DN"), "Bias"),
    optional<&Detector::bit_depth>("bit_depth", within(1, 32, "bits"),
                                   "Bits of a count: counts are rounded to whole DN, ties to even, and clipped to 0 "
                                   "... 2^bits - 1; not rounded if not given"),
    optional<&Detector::bad_pixels_file>("bad_pixels",
                                         "Pixels that no estimator uses: .npy (from FITS: toliman convert) of the "
                                         "frames' shape, 0 for a good pixel; a bad pixel has infinite variance, and "
                                         "simulated frames have its light")
        .checked<read_bad_pixels>(),
    optional<read_window>(
        "window", within(0, 65535, "px"),
        "Row and column on the detector of the frames' first pixel: in frames of another window, bad_pixels "
        "are at their places on the detector; without it, at the same place in all frames")
        .as(Type::integers)
        .entries(2, 2),
    optional<&Detector::sidelobe>("sidelobe", &kSidelobe),
    reserved("bin", "Pixels binned along each side"),
};

// A number is the rms; an object gives rms and drift. The range bounds the rms and the total drift over the cadence.
void read_disturbance(const Reader &reader, const Row &row, Disturbance &disturbance) {
    if (!reader.has_object(row.key)) {
        disturbance.rms = reader.number(row) * row.scale;
        return;
    }
    const Reader object = reader.object(row.key);
    object.allow({"rms", "drift_per_day"});
    const double most = row.range.high, days = longest_days(reader.scene().cadence);
    const char *const unit = row.range.unit;
    disturbance.rms = object.number("rms", row.range) * row.scale;
    if (!object.has("drift_per_day"))
        return;
    const double per_day = object.number("drift_per_day", within(-most, most, unit));
    const double drift = std::fabs(per_day) * days;
    if (drift > most)
        object.refuse(Status::scene, "drift_per_day",
                      " = %g: amounts to %g in the cadence's %g days: must be at most %g%s%s", per_day, drift, days,
                      most, unit[0] != '\0' ? " " : "", unit);
    disturbance.drift_per_day = per_day * row.scale;
}

template <auto member> void read_member(const Reader &reader, const Row &row, Systematics &systematics) {
    read_disturbance(reader, row, systematics.*member);
}

constexpr int kFocus = 4, kFirstOther = 5; // Noll's numbers

void read_zernike(const Reader &reader, const Row &row, int noll, Systematics &systematics) {
    Disturbance zernike;
    read_disturbance(reader, row, zernike);
    if (zernike.any())
        systematics.zernikes_nm.push_back({noll, zernike});
}

void read_focus(const Reader &reader, const Row &row, Systematics &systematics) {
    read_zernike(reader, row, kFocus, systematics);
}

void read_zernike_disturbances(const Reader &reader, const Row &row, Systematics &systematics) {
    const Reader zernikes = reader.object(row.key);
    for (const std::string &key : zernikes.names()) {
        Row one = row;
        one.key = key.c_str();
        read_zernike(zernikes, one, noll_of(zernikes, key, kFirstOther), systematics);
    }
}

void read_jitter(const Reader &reader, const Row &row, Systematics &systematics) {
    Disturbance jitter;
    read_disturbance(reader, row, jitter);
    if (jitter.drift_per_day != 0)
        reader.refuse(Status::unsupported, row.key,
                      ".drift_per_day = %g: must be 0: the blur is the same in all frames", jitter.drift_per_day);
    systematics.jitter.xx = systematics.jitter.yy = jitter.rms * jitter.rms;
}

// A blur along a line has xy = sqrt(xx yy), which may be rounded.
void check_covariance(const Reader &reader, const Systematics &systematics) {
    const Jitter &jitter = systematics.jitter;
    const double most = std::sqrt(jitter.xx * jitter.yy);
    if (std::fabs(jitter.xy) > most * (1 + 1e-12))
        reader.refuse(Status::scene, "jitter_covariance_px2.xy",
                      " = %g: must be in [-%g, %g] px^2, the square root of xx times yy", jitter.xy, most, most);
}

constexpr Range kVariance = within(0, 100, "px^2");
constexpr Row kJitterRows[] = {
    required<&Jitter::xx>("xx", kVariance, "Variance in x"),
    required<&Jitter::yy>("yy", kVariance, "Variance in y"),
    optional<&Jitter::xy>("xy", within(-100, 100, "px^2"), "Covariance; xy^2 is at most xx yy"),
};
constexpr Group kJitter = group_of("jitter",
                                   "Covariance of a Gaussian blur of the image, x to higher columns and y to "
                                   "higher rows",
                                   kJitterRows);

constexpr Row kSmearRows[] = {
    required<&Smear::kind>("kind", Words{"linear harmonic"},
                           "linear: constant speed along the path; harmonic: whole periods of a sinusoid, whose "
                           "amplitude is half the length"),
    required<&Smear::length_px>("length_px", within(0, 20, "px"), "Length of the whole path"),
    required<&Smear::angle_deg>("angle_deg", kTurn, "Direction, from +x (higher columns) towards +y (higher rows)"),
};
constexpr Group kSmear = group_of("smear",
                                  "Motion of the image within every exposure, on a straight path about the image's "
                                  "mean place",
                                  kSmearRows);

template <auto member> constexpr Row drifting(const char *key, double most, const char *unit, const char *text) {
    return optional<read_member<member>>(key, within(0, most, unit), text).as(Type::number_or_drift);
}

constexpr Row kSystematicsRows[] = {
    drifting<&Systematics::pointing_px>("pointing_rms_px", 10, "px", "Pointing; x and y independently"),
    drifting<&Systematics::roll_rad>("roll_rms_deg", 10, "deg",
                                     "Roll: the positions of the stars rotate about the frame's centre, their images "
                                     "do not")
        .scaled(kPi / 180),
    drifting<&Systematics::scale>("scale_rms", 0.01, "", "Pixel scale, relative"),
    optional<read_focus>(
        "focus_rms_nm", within(0, 1000, "nm"),
        "Focus, rms of the wavefront. Frames with focus_rms_nm, zernike_rms_nm or scale_rms are exact, "
        "each propagated: 0.1 to 0.3 s of a core for 256 x 256 px instead of 2 ms")
        .as(Type::number_or_drift),
    optional<read_zernike_disturbances>(
        "zernike_rms_nm", within(0, 1000, "nm"),
        "Zernike coefficients by Noll index, rms of the wavefront over the full aperture")
        .as(Type::drifts_by_index)
        .entries(kFirstOther, kernels::kLargestNoll),
    drifting<&Systematics::flux>("flux_rms", 0.1, "", "Flux, relative; both stars independently"),
    drifting<&Systematics::background_photons>("background_rms_photons", 1e9, "photons",
                                               "Uniform light, photons per pixel before qe; may be negative, but no "
                                               "expected pixel is below 0. Estimators do not know it"),
    optional<read_jitter>("jitter_sigma_px", within(0, 10, "px"),
                          "Jitter within a frame: a Gaussian blur, the same in all frames")
        .as(Type::number_or_rms)
        .either("jitter_covariance_px2"),
    optional<&Systematics::jitter>("jitter_covariance_px2", &kJitter,
                                   "Jitter that differs between x and y; instead of jitter_sigma_px")
        .checked<check_covariance>(),
    optional<&Systematics::smear>("smear", &kSmear),
};

} // namespace

constexpr Group kDetector = group_of("detector", "Detector", kDetectorRows);
constexpr Group kSystematics =
    group_of("systematics",
             "Systematic effects that vary from frame to frame: frame k has rms times a normal "
             "variate of its own, plus drift_per_day times its time; rms and the total drift "
             "over the cadence have the same bound",
             kSystematicsRows);

} // namespace toliman::scene
