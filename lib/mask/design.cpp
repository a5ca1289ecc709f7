// Method: the mask is a level set (mask/level_set.hpp). Adam descends on the objective of a sketch of the scene: cells
// and pixels no finer than the light needs, the middle of the frame, and as many wavelengths as an accuracy of 1e-6
// needs. Fewer would be exploited: with eight, the true bound is 1.36 times that of the sketch; with three, the true
// peak 1.5 times. The slope of the sigmoid grows until cells are 0 or 1, and the weight of the peak with it. Then the
// sketch becomes wider, its limits are set such that the whole frame meets those of the options, and the descent goes
// on until the finished mask does. Small features are removed, and the scenes themselves judge the mask. Why from a
// spiral: from random heights the descent ends at bounds 25 to 50 % larger. Why with nuisances free: a mask for the
// bound with all else known has one 20 % larger with the eight free. References: Wong et al. 2021, J. Opt. Soc. Am. B
// 38, 2465; Kingma and Ba 2015, ICLR (Adam).
#include "mask/design.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>

#include "base/constants.hpp"
#include "base/text.hpp"
#include "base/workers.hpp"
#include "mask/features.hpp"
#include "mask/objective.hpp"
#include "mask/spiral.hpp"
#include "optics/mask_cells.hpp"

namespace toliman::mask {

namespace {

constexpr double kSketchAccuracy = 1e-6;
constexpr size_t kSketchCells = 128;
constexpr double kLargestPitch = 0.46;              // of the sketch's pixels, in lambda/D of the shortest wavelength
constexpr double kFirstField = 56, kLastField = 66; // width of the sketch, in the same unit
constexpr double kRate = 0.06, kDecay1 = 0.9, kDecay2 = 0.98, kTiny = 1e-12; // of Adam
constexpr double kFirstSlope = 3, kLastSlope = 40, kFirstWeight = 0.02, kLastWeight = 1, kLightWeight = 100;
constexpr double kSmoothing = 0.7, kLeastSmoothing = 2.8; // standard deviation: sides of a feature, cells
constexpr double kFirstPeak = 1.09;                       // of the first sketch over that of the frame
constexpr double kDrawPenalty = 0.35, kFirstTighter = 0.985, kTighter = 0.995, kNearly = 0.998;
constexpr size_t kCorrections = 6;

double shortest_m(const Scene &scene) {
    const std::vector<double> wavelengths = optics::make_light(scene).wavelength_m;
    return *std::min_element(wavelengths.begin(), wavelengths.end());
}

// A mask of cells with the step of the scene's mask or, if it has none, half of the middle wavelength: a phase step of
// pi.
Mask mask_of_cells(const Scene &scene) {
    Mask mask;
    mask.kind = Mask::Kind::file;
    mask.opd_nm = scene.telescope.mask.opd_nm;
    mask.height_nm = scene.telescope.mask.height_nm;
    if (mask.step_m() == 0) {
        const std::vector<double> wavelengths = optics::make_light(scene).wavelength_m;
        const auto [least, most] = std::minmax_element(wavelengths.begin(), wavelengths.end());
        mask.opd_nm = std::nearbyint((*least + *most) / 4 * 1e10) / 10;
    }
    return mask;
}

// Cells per axis of the sketch, a divisor of the mask's. Files of the pupil have a fixed size.
size_t sketch_cells(const Scene &scene) {
    const Telescope &telescope = scene.telescope;
    const size_t cells = telescope.pupil_samples;
    size_t ratio = telescope.amplitude_file.empty() && telescope.opd_file.empty() ? cells / kSketchCells : 1;
    while (ratio > 1 && cells % ratio != 0)
        ratio--;
    return cells / std::max<size_t>(ratio, 1);
}

// Pixels are binned as far as the light has no finer structure.
struct Sketch {
    Scene scene;
    double binned;       // pixels of the scene per pixel of the sketch and axis
    double frame_pixels; // of the whole frame, in pixels of the sketch
};

// field: width in lambda/D of the shortest wavelength.
Sketch sketch_of(const Scene &full, double field) {
    const double pitch = full.detector.pixel_scale_arcsec * kPi / 648000 * full.telescope.aperture_m / shortest_m(full);
    const double binned = std::max(1.0, std::floor(kLargestPitch / pitch));
    const auto part = [&](size_t pixels) {
        const double whole = std::max(std::floor(static_cast<double>(pixels) / binned), 1.0);
        return static_cast<size_t>(std::min(whole, 2 * std::round(field / (2 * pitch * binned))));
    };
    const double pixels = static_cast<double>(full.detector.rows * full.detector.cols);
    Sketch sketch = {full, binned, pixels / (binned * binned)};
    Scene &scene = sketch.scene;
    scene.telescope.pupil_samples = sketch_cells(full);
    scene.detector.rows = part(full.detector.rows);
    scene.detector.cols = part(full.detector.cols);
    scene.detector.pixel_scale_arcsec *= binned;
    scene.detector.flat_rms = 0;
    scene.detector.response.clear();
    scene.detector.transfer_smear = scene.detector.interpixel_capacitance = 0;
    scene.detector.brighter_fatter_px2_per_e = scene.detector.nonlinearity_per_e = 0;
    Jitter &jitter = scene.systematics.jitter;
    for (double *const variance : {&scene.detector.diffusion_px2, &jitter.xx, &jitter.yy, &jitter.xy})
        *variance /= binned * binned;
    if (scene.systematics.smear)
        scene.systematics.smear->length_px /= binned;
    scene.detector.dark_e_per_s *= binned * binned;
    scene.noise.read_e *= binned;
    scene.cadence.peak_photons *= binned * binned;
    for (double &offset : scene.binary.offsets_px)
        offset /= binned;
    scene.accuracy = kSketchAccuracy;
    return sketch;
}

Scene with_accuracy(Scene scene, double accuracy) {
    scene.accuracy = accuracy;
    return scene;
}

// The objectives of all places.
class Places {
  public:
    Places(const std::vector<Scene> &scenes, const DesignOptions &options, double step_m) {
        for (const Scene &scene : scenes)
            add(scene, options, step_m);
    }
    Places(const std::vector<Scene> &scenes, const DesignOptions &options, double step_m, double field) {
        for (const Scene &scene : scenes) {
            const Sketch sketch = sketch_of(scene, field);
            add(sketch.scene, options, step_m);
            binned_ = sketch.binned;
            frame_pixels_ = sketch.frame_pixels;
        }
    }
    double binned() const noexcept { return binned_; }
    double frame_pixels() const noexcept { return frame_pixels_; }
    Objective &operator[](size_t place) const noexcept { return *objectives_[place]; }

    Score score(size_t place, const Buffer<double> &covered) const {
        return objectives_[place]->judge(covered, frame_pixels_);
    }

  private:
    void add(const Scene &scene, const DesignOptions &options, double step_m) {
        objectives_.push_back(
            std::make_unique<Objective>(without_signal(scene), options.free, step_m, worker_count(options.workers)));
        frame_pixels_ = static_cast<double>(scene.detector.rows * scene.detector.cols);
    }

    std::vector<std::unique_ptr<Objective>> objectives_;
    double binned_ = 1, frame_pixels_ = 0;
};

class Adam {
  public:
    explicit Adam(size_t count) : mean_(count), square_(count) {}
    void step(const Buffer<double> &gradient, double rate, Buffer<double> &values) {
        steps_++;
        const double first = 1 - std::pow(kDecay1, steps_), second = 1 - std::pow(kDecay2, steps_);
        for (size_t i = 0; i < values.size(); i++) {
            mean_[i] += (1 - kDecay1) * (gradient[i] - mean_[i]);
            square_[i] += (1 - kDecay2) * (gradient[i] * gradient[i] - square_[i]);
            values[i] -= rate * mean_[i] / first / (std::sqrt(square_[i] / second) + kTiny);
        }
    }

  private:
    Buffer<double> mean_, square_;
    double steps_ = 0;
};

// A part of the descent. Slope and weight of the peak grow exponentially; the rate falls at the end.
struct Course {
    const char *name;
    size_t iterations;
    double first_slope, first_weight, rate;
};

double between(double first, double last, double fraction) {
    return first * std::pow(last / first, std::min(fraction, 1.0));
}

// Fraction of each coarse cell [coarse][coarse] that is covered.
Buffer<double> covered_by(const Buffer<uint8_t> &cells, size_t fine, size_t coarse) {
    const size_t ratio = fine / coarse;
    Buffer<double> covered(coarse * coarse);
    for (size_t i = 0; i < cells.size(); i++)
        covered[i / fine / ratio * coarse + i % fine / ratio] += cells[i] / static_cast<double>(ratio * ratio);
    return covered;
}

class Designer {
  public:
    Designer(const std::vector<Scene> &scenes, const DesignOptions &options);
    Design run();

  private:
    // Of the frame, and what the sketch must meet for it.
    struct Target {
        double peak_to_mean, light_in_frame;
        double peak_share = kFirstPeak, light_share = 0; // sketch over frame; the first descent has no limit of light
        double peak_factor = 1, light_factor = 1;        // limits in the descent over those asked for
    };

    void draw(const Places &sketch);
    void descend(const Places &sketch, const Course &course);
    bool meets_targets(const Places &sketch, const Places &full);
    void finish_cells();
    bool goes_on(const char *stage, double fraction);

    const std::vector<Scene> &scenes_;
    const DesignOptions &options_;
    const size_t fine_, coarse_;
    Buffer<double> open_;
    LevelSet level_;
    Adam adam_;
    Buffer<double> heights_;
    std::vector<Target> targets_;
    Design design_;
};

Designer::Designer(const std::vector<Scene> &scenes, const DesignOptions &options)
    : scenes_(scenes), options_(options), fine_(scenes[0].telescope.pupil_samples), coarse_(sketch_cells(scenes[0])),
      open_(optics::make_pupil(scenes[0], fine_).amplitude),
      level_(coarse_,
             std::max(kLeastSmoothing, kSmoothing * static_cast<double>(options.feature_cells)) *
                 static_cast<double>(coarse_) / static_cast<double>(fine_),
             fine_, coarse_, open_, options.symmetry),
      adam_(coarse_ * coarse_) {
    design_.samples = fine_;
    design_.mask = mask_of_cells(scenes[0]);
    for (const Scene &scene : scenes) {
        design_.own.push_back(
            score_of(without_signal(with_accuracy(scene, optics::kBoundAccuracy)), scene.telescope.mask, options.free));
        targets_.push_back({options.peak_to_mean > 0 ? options.peak_to_mean : design_.own.back().peak_to_mean,
                            options.light_in_frame});
    }
}

bool Designer::goes_on(const char *stage, double fraction) {
    char text[100];
    if (design_.bounds_px.empty())
        print_text(text, sizeof text, "%s", stage);
    else
        print_text(text, sizeof text, "%s: bound %.4g px", stage, design_.bounds_px.back());
    design_.stopped = design_.stopped || options_.progress.asks_to_stop(text, fraction);
    return !design_.stopped;
}

// The best of some random spirals, by bound and peak. A symmetric part of 0 gives none.
void Designer::draw(const Places &sketch) {
    constexpr double kLeastHeight = 1e-3;
    const auto draws = static_cast<double>(options_.draws);
    double best = std::numeric_limits<double>::infinity();
    Mask mask;
    mask.kind = Mask::Kind::spiral;
    for (size_t k = 0; k < options_.draws || heights_.empty(); k++) {
        if (!heights_.empty() && !goes_on("draw", static_cast<double>(k) / draws))
            return;
        mask.terms = draw_terms(options_.seed, k);
        Buffer<double> heights = optics::sum_of_terms(mask, coarse_);
        const double rms = level_.set(heights);
        if (rms < kLeastHeight)
            continue;
        const Score score = sketch.score(0, level_.covered(kLastSlope)); // in pixels of the sketch
        const double excess = std::log(score.peak_to_mean / (kFirstPeak * targets_[0].peak_to_mean));
        const double loss = std::log(score.crb_px) + kDrawPenalty * std::max(0.0, excess);
        if (loss < best || heights_.empty()) {
            best = loss;
            for (double &height : heights)
                height /= rms;
            heights_ = std::move(heights);
        }
    }
}

void Designer::descend(const Places &sketch, const Course &course) {
    Buffer<double> by_covered;
    for (size_t i = 0; i < course.iterations; i++) {
        const double fraction = static_cast<double>(i) / static_cast<double>(course.iterations);
        if (!goes_on(course.name, fraction))
            return;
        const double slope = between(course.first_slope, kLastSlope, fraction / 0.85);
        const double weight = between(course.first_weight, kLastWeight, fraction / 0.8);
        const size_t place = i % scenes_.size();
        const Target &target = targets_[place];
        level_.set(heights_);
        const Merit merit = sketch[place].evaluate(
            level_.covered(slope),
            {sketch.frame_pixels(), target.peak_share * target.peak_factor * target.peak_to_mean, weight,
             target.light_share * target.light_factor * target.light_in_frame, kLightWeight},
            &by_covered);
        if (!std::isfinite(merit.loss))
            fail(Status::scene,
                 "%s: a mask cannot be designed: the separation has no Cramer-Rao bound with the free "
                 "parameters",
                 scenes_[place].source.c_str());
        design_.bounds_px.push_back(merit.bound_px * sketch.binned());
        adam_.step(level_.gradient(slope, by_covered), course.rate * std::min(1.0, 4 * (1 - fraction) + 0.05),
                   heights_);
    }
}

void Designer::finish_cells() {
    level_.set(heights_);
    design_.cells = without_small_features(level_.cells(), fine_, options_.feature_cells, open_);
}

// Of the finished mask, judged by the scenes. Also sets what the sketch must meet in the next descent: it lacks the
// light beyond it, and its mask is a little grey.
bool Designer::meets_targets(const Places &sketch, const Places &full) {
    finish_cells();
    const Buffer<double> covered = covered_by(design_.cells, fine_, fine_), grey = level_.covered(kLastSlope);
    design_.best.clear();
    bool meets = true;
    for (size_t place = 0; place < scenes_.size(); place++) {
        Target &target = targets_[place];
        const Score score = full.score(place, covered), of_sketch = sketch.score(place, grey);
        target.peak_share = of_sketch.peak_to_mean / score.peak_to_mean;
        target.light_share = of_sketch.light_in_frame / score.light_in_frame;
        if (score.peak_to_mean > target.peak_to_mean) {
            meets = false;
            target.peak_factor *= kTighter * target.peak_to_mean / score.peak_to_mean;
        }
        if (score.light_in_frame < kNearly * target.light_in_frame) {
            meets = false;
            target.light_factor *= target.light_in_frame / score.light_in_frame;
        }
        design_.best.push_back(score);
    }
    return meets;
}

Design Designer::run() {
    {
        const Places sketch(scenes_, options_, design_.mask.step_m(), kFirstField);
        draw(sketch);
        descend(sketch, {"descend", options_.iterations, kFirstSlope, kFirstWeight, kRate});
    }
    const Places sketch(scenes_, options_, design_.mask.step_m(), kLastField);
    std::vector<Scene> accurate;
    for (const Scene &scene : scenes_)
        accurate.push_back(with_accuracy(scene, optics::kBoundAccuracy));
    const Places full(accurate, options_, design_.mask.step_m());
    meets_targets(sketch, full);
    for (Target &target : targets_) {
        target.peak_factor = kFirstTighter;
        target.light_factor = 1;
    }
    descend(sketch, {"polish", options_.iterations * 4 / 5, 0.75 * kLastSlope, kLastWeight, kRate / 2});
    for (size_t i = 0; !meets_targets(sketch, full) && i < kCorrections && !design_.stopped; i++)
        descend(sketch, {"correct", options_.iterations / 8, 0.75 * kLastSlope, kLastWeight, kRate / 4});
    design_.small_cells = small_fraction(design_.cells, fine_, options_.feature_cells, open_);
    return std::move(design_);
}

} // namespace

Design design(const std::vector<Scene> &places, const DesignOptions &options) {
    return Designer(places, options).run();
}

bool is_improved(const Design &design, const DesignOptions &options) noexcept {
    for (size_t i = 0; i < design.best.size(); i++) {
        const Score &own = design.own[i], &best = design.best[i];
        const double peak = options.peak_to_mean > 0 ? options.peak_to_mean : own.peak_to_mean;
        if (!(best.crb_px < own.crb_px && best.peak_to_mean <= peak))
            return false;
    }
    return true;
}

std::string json_of(const Mask &mask) {
    const bool by_opd = mask.opd_nm != 0;
    char digits[32];
    const char *const end = std::to_chars(digits, std::end(digits), by_opd ? mask.opd_nm : mask.height_nm).ptr;
    return R"({"kind": "file", "file": "mask.npy", "quantity": "binary", ")" +
           std::string(by_opd ? "opd_nm" : "height_nm") + "\": " + std::string(static_cast<const char *>(digits), end) +
           "}";
}

Scene at_rest(Scene scene) {
    scene.binary.moving = false;
    scene.binary.sky = nullptr;
    const Systematics before = scene.systematics;
    scene.systematics = {};
    scene.systematics.jitter = before.jitter;
    scene.systematics.smear = before.smear;
    return scene;
}

} // namespace toliman::mask
