#include "report/run_images.hpp"

#include <algorithm>
#include <cmath>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "frames/network.hpp"
#include "report/words.hpp"
#include "scenes/scene.hpp"
#include "scenes/scene_json.hpp"

namespace cli {

namespace {

using toliman::check;
using Image = Numbers;

constexpr size_t kSide = 256;             // of the network's images, and of point spread functions
constexpr double kDepth = 1e-5;           // of a logarithmic scale
constexpr double kBands[] = {0, 50, 110}; // nm
constexpr double kMostDisplacement = 0.1; // px, of the series
constexpr double kStarPhotons = 1e9;      // of a star alone: far above the least that a scene may have

struct Extremes {
    double low, high;
};

Extremes extremes_of(const Image &image) {
    Extremes found = {INFINITY, -INFINITY};
    for (const double value : image)
        if (std::isfinite(value))
            found = {std::min(found.low, value), std::max(found.high, value)};
    if (!(found.low < found.high)) // one value, or none
        found.high = found.low = std::isfinite(found.low) ? found.low : 0, found.high += 1;
    return found;
}

Scale even(const Image &image) {
    const Extremes extremes = extremes_of(image);
    return {Palette::intensity, extremes.low, extremes.high, false};
}

Scale logarithmic(double high) {
    return {Palette::intensity, high * kDepth, high, true};
}

Scale around_zero(const Image &image) {
    const Extremes extremes = extremes_of(image);
    const double most = std::max(std::fabs(extremes.low), std::fabs(extremes.high));
    return {Palette::difference, -most, most, false};
}

// So that a colour box has short numbers; returns the unit.
std::string shorten(Image &image, const std::string &unit) {
    const ShortUnit shorter = short_unit(image, unit);
    for (double &value : image)
        value *= shorter.factor;
    return shorter.name;
}

// Of a detector of `count` pixels, where pixel `first` stands.
double place_of(int64_t count, int64_t first = 0) {
    return static_cast<double>(first) - static_cast<double>(count - 1) / 2;
}

const char *unit_of(const toliman_sim_info &info) {
    return info.unit == TOLIMAN_SIM_UNIT_DN ? "DN" : info.unit == TOLIMAN_SIM_UNIT_ELECTRON ? "electrons" : "photons";
}

Panel frame_panel(const std::string &title, const Image &image, const Scene &scene) {
    const toliman_sim_info &info = scene.info;
    Panel panel;
    panel.title = title;
    panel.values = image;
    panel.rows = static_cast<size_t>(info.rows);
    panel.cols = static_cast<size_t>(info.cols);
    panel.x = place_of(info.cols);
    panel.y = place_of(info.rows);
    panel.axis_unit = "px";
    return panel;
}

// A star alone behind the scene's telescope, in a band about the middle of the scene's.
class PointSource {
  public:
    PointSource(const Scene &scene, const std::string &text) : path_(scene.path), scene_(parsed(text)) {
        std::vector<double> waves(static_cast<size_t>(scene.info.wavelengths));
        check(toliman_sim_get_spectrum(scene.sim.get(), waves.size(), waves.data(), nullptr, nullptr));
        const auto [least, greatest] = std::minmax_element(waves.begin(), waves.end());
        middle_nm_ = (*least + *greatest) / 2 * 1e9;
        scale_arcsec_ = scene.info.pixel_scale_arcsec;
    }

    double middle_nm() const noexcept { return middle_nm_; }

    // Fraction of the star's light that falls in each pixel.
    Image image(double width_nm) const {
        const std::string text = json_of(width_nm);
        const Scene star(path_, text);
        Image image(star.pixels());
        check(toliman_sim_get_image(star.sim.get(), TOLIMAN_SIM_IMAGE_BOTH, image.data(), kSide));
        for (double &pixel : image)
            pixel /= kStarPhotons;
        return image;
    }

    Panel panel(const std::string &title, const Image &image) const {
        Panel panel;
        panel.title = title;
        panel.values = image;
        panel.rows = panel.cols = kSide;
        panel.x = panel.y = place_of(kSide);
        panel.axis_unit = "px";
        return panel;
    }

  private:
    static JsonTree parsed(const std::string &text) {
        return JsonTree(cJSON_ParseWithLength(text.data(), text.size())); // the library has read it
    }

    std::string json_of(double width_nm) const {
        Json json, band, stars, star, spectrum, cadence, detector;
        if (width_nm > 0)
            band.set("min_nm", middle_nm_ - width_nm / 2).set("max_nm", middle_nm_ + width_nm / 2).set("step_nm", 1.0);
        else
            band.set("wavelength_nm", middle_nm_);
        spectrum.set("kind", std::string("blackbody")).set("temperature_k", 5790.0);
        star.set("spectrum", std::move(spectrum)).set("photons_per_s", kStarPhotons);
        stars.set("A", std::move(star));
        cadence.set("frames", 1.0).set("exposure_s", 1.0);
        const double shape[] = {kSide, kSide};
        detector.set("shape", JsonTree(cJSON_CreateDoubleArray(shape, 2))).set("pixel_scale_arcsec", scale_arcsec_);
        json.set("schema", "toliman-scene/1");
        json.set("telescope", copy_of(item_of(scene_.get(), "telescope"))).set("band", std::move(band));
        json.set("stars", std::move(stars)).set("cadence", std::move(cadence)).set("detector", std::move(detector));
        return json.set("accuracy", 1e-6).text();
    }

    std::string path_;
    JsonTree scene_;
    double middle_nm_ = 0, scale_arcsec_ = 0;
};

Panel pupil_panel(const Scene &scene) {
    const auto side = static_cast<size_t>(scene.info.pupil_samples);
    Image amplitude(side * side), opd(amplitude.size());
    check(toliman_sim_get_pupil(scene.sim.get(), amplitude.data(), opd.data()));
    for (size_t i = 0; i < opd.size(); i++)
        opd[i] = amplitude[i] > 0 ? opd[i] * 1e9 : NAN;
    const double step = scene.info.aperture_m * 1e3 / static_cast<double>(side);
    Panel panel;
    panel.title = "pupil";
    panel.scale = even(opd);
    panel.values = std::move(opd);
    panel.rows = panel.cols = side;
    panel.step = step;
    panel.x = panel.y = step * place_of(scene.info.pupil_samples);
    panel.axis_unit = "mm";
    panel.value_unit = "optical path difference, nm";
    return panel;
}

double highest(const Image &image) {
    return *std::max_element(image.begin(), image.end());
}

// One wavelength, then wider bands; `remark` tells of those that are no scene, as where the pupil has too few samples.
std::vector<Panel> band_panels(const PointSource &source, const std::string &middle, std::string &remark) {
    std::vector<Panel> panels;
    double most = 0;
    for (const double width : kBands) {
        const std::string title = width > 0 ? printed("%g nm about ", width) + middle : middle;
        try {
            panels.push_back(source.panel(title, source.image(width)));
        } catch (const toliman::error &error) {
            if (error.status() != TOLIMAN_E_SCENE)
                throw;
            remark += " Not shown: " + title + ": " + escaped(error.what()) + ".";
            continue;
        }
        most = std::max(most, highest(panels.back().values));
    }
    for (Panel &panel : panels)
        panel.scale = logarithmic(most);
    if (!panels.empty())
        panels.back().value_unit = "fraction of the light in a pixel";
    return panels;
}

void add_optics(const Scene &scene, const std::string &text, Page &page) {
    const PointSource source(scene, text);
    const std::string middle = printed("%.4g nm", source.middle_nm());
    std::string remark;
    const std::vector<Panel> bands = band_panels(source, middle, remark);
    std::vector<Panel> pupil = {pupil_panel(scene)};
    std::string of_pupil = "The mask in the pupil, grey where no light comes through";
    if (!bands.empty()) {
        pupil.push_back(bands.front());
        pupil[1].title = "point spread function at " + bands.front().title;
        pupil[1].value_unit = bands.back().value_unit;
        of_pupil += ", and what it makes of a star, a black body of 5790 K, at " + bands.front().title;
    }
    page.add(panel_figure("pupil", of_pupil + "." + (bands.empty() ? remark : ""), pupil));
    if (!bands.empty())
        page.add(panel_figure("bandwidths",
                              "The same star at one wavelength and in wider bands, same colours: the fringes far from "
                              "the middle wash out, those near it stay." +
                                  remark,
                              bands));
}

Image expected(const Scene &scene, double displacement) {
    Image image(scene.pixels());
    const auto cols = static_cast<size_t>(scene.info.cols);
    const auto work = std::fabs(displacement) <= kMostDisplacement ? toliman_sim_expect : toliman_sim_propagate;
    check(work(scene.sim.get(), displacement, image.data(), cols));
    return image;
}

Image first_frame(const Scene &scene, uint64_t seed) {
    Image image(scene.pixels());
    check(toliman_sim_frame_many(scene.sim.get(), nullptr, seed, 0, 1, 0, image.data()));
    return image;
}

Image variance_of(const Scene &scene) {
    Image image(scene.pixels());
    check(toliman_sim_get_image(scene.sim.get(), TOLIMAN_SIM_IMAGE_VARIANCE, image.data(),
                                static_cast<size_t>(scene.info.cols)));
    return image;
}

// Else the variance is not that of the frames: it holds photon noise in any case.
bool has_photon_noise(const Scene &scene) {
    toliman_sim_plan_info plan = {};
    plan.struct_size = sizeof plan;
    check(toliman_sim_get_plan(scene.sim.get(), &plan));
    return has_stage(plan, "photon noise");
}

// Standard deviation of the noise in the brightest pixel.
double brightest_noise(const Scene &scene, const Image &still) {
    const auto brightest = std::max_element(still.begin(), still.end());
    return std::sqrt(variance_of(scene)[static_cast<size_t>(brightest - still.begin())]);
}

void add_frame(const Scene &scene, const Image &frame, Page &page) {
    std::vector<Panel> panels = {frame_panel("frame 0", frame, scene)};
    panels[0].scale = logarithmic(highest(frame));
    panels[0].value_unit = unit_of(scene.info);
    std::string caption = "The first frame as the detector has it, brightest pixel " + scientific(highest(frame)) +
                          " " + unit_of(scene.info) + ".";
    const double amplitude =
        std::max(std::fabs(scene.info.min_displacement_px), std::fabs(scene.info.max_displacement_px));
    if (amplitude > 0) {
        Image wobble = expected(scene, amplitude);
        const Image still = expected(scene, 0);
        std::transform(wobble.begin(), wobble.end(), still.begin(), wobble.begin(), std::minus<double>());
        const Extremes extremes = extremes_of(wobble);
        caption += " Right: the expected frame at the signal's greatest displacement, " + scientific(amplitude) +
                   " px, less the one without, from " + scientific(extremes.low) + " to " + scientific(extremes.high) +
                   " " + unit_of(scene.info) + ".";
        if (has_photon_noise(scene))
            caption += " The noise of the brightest pixel has a standard deviation of " +
                       scientific(brightest_noise(scene, still)) + ".";
        const std::string unit = shorten(wobble, unit_of(scene.info));
        panels.push_back(frame_panel("what the wobble changes", wobble, scene));
        panels[1].scale = around_zero(wobble);
        panels[1].value_unit = unit;
    }
    page.add(panel_figure("frame", caption, panels));
}

// The part of a frame that the network sees.
Image cropped(const Image &frame, const Scene &scene, const toliman_cae_info &cae) {
    const auto cols = static_cast<size_t>(scene.info.cols);
    Image part;
    for (size_t row = 0; row < kSide; row++) {
        const auto start = frame.begin() +
                           static_cast<std::ptrdiff_t>((static_cast<size_t>(cae.crop_row) + row) * cols) + cae.crop_col;
        part.insert(part.end(), start, start + kSide);
    }
    return part;
}

// The difference in units of the noise, and what is said of it.
Panel residual_panel(Panel panel, const Image &original, const Image &again, const Image &variance,
                     std::string &caption) {
    Image residual(again.size());
    double square = 0;
    for (size_t i = 0; i < residual.size(); i++) {
        residual[i] = (original[i] - again[i]) / std::sqrt(variance[i]);
        square += residual[i] * residual[i] / static_cast<double>(residual.size());
    }
    panel.title = "residual over its sigma";
    panel.values = std::move(residual);
    panel.scale = {Palette::difference, -4, 4, false};
    panel.value_unit = "sigma of the pixel";
    caption +=
        "; the difference in units of the noise: rms " + fixed(std::sqrt(square), 3) + ", where noise alone has 1";
    return panel;
}

void add_reconstruction(const Scene &scene, const Image &frame, const Network &network, Page &page) {
    const toliman_cae_info &facts = network.info;
    Image again(kSide * kSide);
    double mmse = 0, mssim = 0, floor = 0;
    check(toliman_cae_reconstruct(network.cae.get(), frame.data(), static_cast<size_t>(scene.info.cols), again.data(),
                                  kSide, &mmse, &mssim, &floor));
    Panel panel;
    panel.rows = panel.cols = kSide;
    panel.x = place_of(scene.info.cols, facts.crop_col);
    panel.y = place_of(scene.info.rows, facts.crop_row);
    panel.axis_unit = "px";
    std::vector<Panel> panels(2, panel);
    panels[0].title = "frame 0";
    panels[1].title = "reconstruction";
    panels[0].values = cropped(frame, scene, facts);
    panels[1].values = again;
    panels[0].scale = panels[1].scale = logarithmic(highest(panels[0].values));
    panels[1].value_unit = unit_of(scene.info);
    std::string caption = "The first frame and what the network makes of its one number", alone;
    if (has_photon_noise(scene)) {
        panels.push_back(
            residual_panel(panel, panels[0].values, again, cropped(variance_of(scene), scene, facts), caption));
        alone = ", noise alone " + scientific(floor, 4);
    }
    page.add(panel_figure("reconstruction",
                          caption + ". Of this frame MMSE " + scientific(mmse, 4) + alone + ", 1 &minus; MSSIM " +
                              scientific(1 - mssim, 2) + ".",
                          panels));
}

} // namespace

void add_run_images(const std::string &folder, const std::string &scene_folder, uint64_t seed, Page &page) {
    const std::string text = whole_text(folder + "/scene.json");
    const Scene scene(scene_folder + "/scene.json", text);
    const Network network(folder + "/weights.tlmw");
    if (network.info.scene_digest != scene.info.scene_digest)
        malformed(folder, "scene.json and weights.tlmw are of different scenes");
    const Image frame = first_frame(scene, seed);
    add_optics(scene, text, page);
    add_frame(scene, frame, page);
    add_reconstruction(scene, frame, network, page);
}

} // namespace cli
