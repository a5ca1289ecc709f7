// A scene: the validated input of a simulation, read from JSON (schema toliman-scene/1) by read_scene().
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/goodness.hpp"
#include "frame/detector_window.hpp"
#include "scene/parameter.hpp"
#include "sky/prediction.hpp"

namespace toliman {

constexpr double kLargestDisplacement = 0.1;  // px, by Taylor expansion
constexpr double kFarthestDisplacement = 100; // px, of a propagated image
constexpr size_t kMostPupilSamples = 2048;    // per axis
constexpr double kFewestPhotons = 1e-6;       // in the brightest pixel; far below any use, far above underflow

struct Struts {
    int count = 0;
    double width_m = 0;
    double angle_deg = 0; // of the first, from +x towards +y; the others are at equal spacing
};

// One term of a spiral mask: the phase steps where the sum of the terms is positive.
struct SpiralTerm {
    double a, f, l, m, p; // a cos(2 pi f r + l ln r + m theta + p), r in units of the aperture's radius
};

struct Mask {
    enum class Kind { clear, spiral, file } kind = Kind::clear;
    enum class Quantity { binary, opd_m, phase_rad } quantity = Quantity::binary; // what the file holds
    enum class Edges { cell, area } edges = Edges::area; // of a spiral on the cells of the pupil
    double rotation_deg = 0, shift_m[2] = {0, 0}; // of a spiral: about its centre from +x towards +y, then [x, y]
    double opd_nm = 0, height_nm = 0; // of the step, where a spiral's sum is positive or a binary file is 1; one is 0
    double reference_m = 0;           // wavelength of a phase
    std::vector<SpiralTerm> terms;
    std::string file;

    double step_m() const noexcept { return opd_nm != 0 ? opd_nm * 1e-9 : height_nm * 2e-9; } // OPD
};

struct ZernikeTerm {
    int noll;
    double rms_m; // OPD over the full aperture
};

// One factor of the throughput: a constant, or a file with a value per wavelength.
struct Throughput {
    double factor = 1;
    std::string file; // "" = the factor
};

struct Telescope {
    double aperture_m = 0;
    double secondary_m = 0; // diameter of the central obstruction
    Struts struts;
    size_t pupil_samples = 256;
    std::string amplitude_file; // "" = none
    Mask mask;
    std::vector<ZernikeTerm> zernikes;
    std::string opd_file; // "" = none
    std::vector<Throughput> throughput;
};

struct Band {
    double min_nm = 0, max_nm = 0;
    size_t steps = 0; // uniform; 0 = one wavelength, min_nm
};

struct Spectrum {
    enum class Kind { blackbody, table, lines } kind = Kind::blackbody;
    double temperature_k = 0; // of a black body
    std::string file;
    double star_temperature_k = 0, table_temperature_k = 0; // ratio of black bodies that multiplies the table; 0 = none
    std::vector<double> wavelength_nm, weight;              // lines
    std::vector<double> modes;                              // coefficients of Legendre polynomials 1, 2, ...
};

struct Star {
    Spectrum spectrum;
    // Over the band, behind the throughput and before the quantum efficiency. A magnitude in a band determines it once
    // the pupil is known (optics/photometry.hpp).
    std::optional<double> photons_per_s;
    bool detected = false; // photons_per_s are electrons
    std::optional<double> relative_flux, magnitude, mass_sun;
    std::string magnitude_band; // "V", or a file; "" = none
    enum class System { vega, ab } system = System::vega;
};

struct Binary {
    enum class Centre { barycentre, a, b } centre = Centre::barycentre;
    double separation_arcsec = 0, position_angle_deg = 0; // of B from A at time 0
    std::optional<sky::Orbit> orbit;
    std::optional<sky::System> system;         // of the orbit, if it is more than elements
    double date = 0;                           // time 0 on the orbit, Julian year
    bool moving = false;                       // the stars follow the orbit through the cadence
    std::shared_ptr<const sky::Predictor> sky; // what the observer sees of it; nullptr: the orbit itself
    std::optional<double> distance_pc;
    bool by_offsets = false;
    double offsets_px[4] = {0, 0, 0, 0}; // Ax, Ay, Bx, By
};

// A sinusoid, or the reflex motion due to a planet on an eccentric orbit, which determines amplitude and period.
struct Signal {
    enum class Kind { none, sinusoid, planet } kind = Kind::none;
    size_t star = 0; // 0 = A, 1 = B
    double amplitude_px = 0, period_days = 0, phase_rad = 0;
    double mass_earth = 0, semi_major_au = 0; // of the planet's orbit relative to its star
    double eccentricity = 0, argument_deg = 0;
};

struct Cadence {
    int64_t frames = 0;
    double interval_days = 1;
    std::vector<double> times_days; // of the frames; empty: k times the interval
    double peak_photons = 0;        // 0: exposure_s is given instead
    double exposure_s = 0;
    std::vector<double> on_target_s; // intervals from the start of an exposure: start and end in turn; empty: all of it
    std::string windows_file;        // instead of on_target_s; "": none
    std::vector<sky::Interval> windows; // of the file, TAI, in order
    double windows_s = 0;               // their time in the first frame that has some
};

double longest_days(const Cadence &cadence) noexcept;         // largest |time| of a frame
double time_days(const Cadence &cadence, int64_t k) noexcept; // of frame k; beyond a list of times, its last entry
double on_target_s(const Cadence &cadence) noexcept;          // in a frame; with windows, in the first
int64_t tai_of_date(double date) noexcept;                    // Julian year of TT
// TAI of time 0 of moving stars; 0 for stars at rest, and for dates that nanoseconds of 64 bits do not reach.
int64_t time_zero_ns(const Binary &binary) noexcept;
// The parts of an exposure, `days` after `zero_ns`, in which the telescope points at the stars; none if no window is in
// it, or its length is unknown.
std::vector<sky::Interval> whole_exposure_at(const Cadence &cadence, int64_t zero_ns, double days);
std::vector<sky::Interval> exposure_at(const Cadence &cadence, int64_t zero_ns, double days);
double seconds_of(const std::vector<sky::Interval> &intervals) noexcept;

// The window around an order of a grating in the pupil, which displaces light by wavelength/period.
struct Sidelobe {
    double period_m = 0;
    double angle_deg = 0;  // from +x towards +y
    double centre_m = 0;   // wavelength of an axial star that is at the centre of the frame
    double efficiency = 1; // share of the light
};

struct Detector {
    size_t rows = 0, cols = 0;
    double pixel_scale_arcsec = 0;
    double focal_length_m = 0;              // 0: not given
    double scale_anisotropy = 0, shear = 0; // geometry.hpp
    double rotation_deg = 0;                // position angle of the +y axis
    bool integrated = false;                // integrate over the pixel's area; otherwise sample the image at its centre
    double qe = 1;                          // electrons per photon
    std::string qe_file;                    // by wavelength, instead; "" = none
    int64_t coadds = 1;                     // frames summed on board
    double flat_rms = 0;                    // of the pixels' response, relative
    double diffusion_px2 = 0;               // variance of the charge's diffusion, along each axis
    double transfer_smear = 0;              // of the light of a pixel, on each pixel of its column
    double brighter_fatter_px2_per_e = 0;   // variance that a pixel's mean charge adds, in each coadded frame
    double interpixel_capacitance = 0;      // share of a pixel's charge that each of its four neighbours measures
    double nonlinearity_per_e = 0;          // charge c of each coadded frame is measured as c - c^2 times this
    double dark_e_per_s = 0;                // per pixel
    std::optional<double> full_well_e;      // of each coadded frame
    double gain_e_per_dn = 1, bias_dn = 0;
    int bit_depth = 0; // 0 = counts are not rounded
    std::string response_file;
    std::vector<double> response; // [rows*cols] of each pixel, relative; empty: 1
    std::string bad_pixels_file;
    std::vector<size_t> bad_pixels;       // row*cols + column of the pixels that estimators do not use, increasing
    std::optional<DetectorWindow> window; // of the frames
    std::optional<Sidelobe> sidelobe;     // whose frames these are

    // Whether the response is that of other pixels in a frame of this window. Without detector.window, the file is that
    // of [0, 0], where frames are whose window is not known.
    bool response_moves_with(const std::optional<DetectorWindow> &of_frame) const noexcept {
        return !response.empty() && of_frame && !(window.value_or(DetectorWindow()) == *of_frame);
    }
    // The window in words of an error.
    std::string window_text() const {
        return window ? "[" + std::to_string(window->row) + ", " + std::to_string(window->col) + "]"
                      : "[0, 0] as it is not given";
    }
};

// One kind of systematics: frame k has rms times its own normal variate, plus the drift times its time in days.
struct Disturbance {
    double rms = 0, drift_per_day = 0;
    bool any() const noexcept { return rms != 0 || drift_per_day != 0; }
};

struct ZernikeDisturbance {
    int noll;
    Disturbance rms_nm; // of the wavefront
};

// Covariance of the jitter within a frame, px^2.
struct Jitter {
    double xx = 0, yy = 0, xy = 0;
    bool any() const noexcept { return xx != 0 || yy != 0; }
};

// Motion of the image within each exposure, along a straight path about its mean place.
struct Smear {
    enum class Kind { linear, harmonic } kind = Kind::linear; // at constant speed; whole periods of a sinusoid
    double length_px = 0;                                     // of the whole path
    double angle_deg = 0;                                     // from +x towards +y
};

struct Systematics {
    Disturbance pointing_px, roll_rad, scale, flux, background_photons;
    std::vector<ZernikeDisturbance> zernikes_nm; // focus first, as the fourth, if it varies
    Jitter jitter;                               // the same blur in all frames, as smear, hence not counted by any()
    std::optional<Smear> smear;
    bool any() const noexcept {
        return pointing_px.any() || roll_rad.any() || flux.any() || background_photons.any() || changes_optics();
    }
    bool changes_optics() const noexcept { return scale.any() || !zernikes_nm.empty(); }
};

struct Noise {
    bool photon = false;
    double read_e = 0;
    uint64_t seed = 0;
};

// Verdict of the calibration that fitted the scene.
struct SceneCalibration {
    Goodness goodness;     // of its frames; unknown for a calibration that was stopped, and for files without it
    bool stated = true;    // whether the file has a verdict
    bool complete = false; // the model explained the frames, and the noise is theirs
    int64_t frames = 0;
};

struct Scene {
    std::string source;       // name of the scene in messages: its path as given
    std::string name;         // as base/name.hpp allows, or ""
    uint64_t digest = 0;      // FNV-1a of the JSON text
    std::string json, folder; // the JSON text, and the folder at which its relative file names start
    Telescope telescope;
    std::optional<Band> band;
    std::vector<Star> stars; // A, then B if there is one
    Binary binary;
    Signal signal;
    Cadence cadence;
    Detector detector;
    Noise noise;
    Systematics systematics;
    std::vector<Parameter> projected; // preprocess.project
    double accuracy = 1e-9;
    std::optional<SceneCalibration> calibration; // present if the scene has this group
};

// The text of a scene with this file as detector.bad_pixels, by its absolute path.
std::string with_bad_pixels(const std::string &json, const std::string &source, const std::string &path);

// Reads a scene from JSON text. File names in it are relative to `folder`; of the files only times_days, response and
// bad_pixels are read, the others are checked to exist. Status::format if the text is not JSON, Status::scene or
// Status::unsupported for its content.
Scene read_scene(const std::string &json, const std::string &source, const std::string &folder);

} // namespace toliman
