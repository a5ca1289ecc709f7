// Method: the text of the nominal scene is parsed, the members of the fitted parameters are replaced, and the tree is
// printed: what was not fitted remains as its author wrote it. Relative names of files are converted from the folder of
// the nominal scene to that of the new one. Maps are .npy files next to it, written first, so that the scene never
// names a file that does not exist. The group `calibration` states the verdict and what the fit was made with.
// Why covariances are limited: a scene refuses a jitter with xy^2 > xx yy, which rounding at the bound may leave.
#include "calibrate/fitted.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "backend/file.hpp"
#include "backend/json.hpp"
#include "base/error.hpp"
#include "base/text.hpp"
#include "optics/pupil.hpp"
#include "scene/instrument.hpp"

namespace toliman::calibrate {

namespace {

using json::Value;
using Kind = Parameter::Kind;

constexpr size_t kNpyHeader = 128; // bytes, a multiple of 64

// Whether the text of a key is the name of a file.
bool is_file(const std::string &key, const std::string &text) {
    return key == "file" || key == "opd_file" || key == "times_days" || key == "bad_pixels" || key == "response" ||
           key == "on_target" || key == "qe" || key == "throughput" || (key == "magnitude_band" && text != "V") ||
           (key == "orbit" && text != "alpha-cen");
}

// Relative file names, anywhere in the scene, from the nominal scene's folder to the new one. key: of the value, or of
// the array that it is in.
void move_files(const std::string &key, Value &value, const std::filesystem::path &from,
                const std::filesystem::path &to) {
    if (value.kind == Value::Kind::text && is_file(key, value.text) && std::filesystem::path(value.text).is_relative())
        value.text = (from / value.text).lexically_normal().lexically_relative(to.lexically_normal()).generic_string();
    for (size_t i = 0; i < value.items.size(); i++)
        move_files(value.kind == Value::Kind::object ? value.names[i] : key, value.items[i], from, to);
}

void set_zernikes(const Scene &scene, Value &telescope) {
    Value &zernikes = telescope.member("aberrations").member("zernike_rms_nm");
    for (const ZernikeTerm &term : scene.telescope.zernikes)
        zernikes.member(std::to_string(term.noll)) = Value::of(term.rms_m * 1e9);
}

void set_jitter(const Scene &scene, Value &systematics) {
    const Jitter &jitter = scene.systematics.jitter;
    systematics.remove("jitter_sigma_px");
    Value &covariance = systematics.member("jitter_covariance_px2");
    const double xx = std::max(0.0, jitter.xx), yy = std::max(0.0, jitter.yy), most = std::sqrt(xx * yy);
    covariance.member("xx") = Value::of(xx);
    covariance.member("yy") = Value::of(yy);
    covariance.member("xy") = Value::of(std::clamp(jitter.xy, -most, most));
}

void set_spectrum(const Scene &scene, size_t star, Value &stars) {
    const Spectrum &spectrum = scene.stars[star].spectrum;
    Value &out = stars.member(star == 0 ? "A" : "B").member("spectrum");
    if (spectrum.kind == Spectrum::Kind::blackbody) {
        out.member("temperature_k") = Value::of(spectrum.temperature_k);
    } else if (spectrum.star_temperature_k != 0) {
        out.member("star_temperature_k") = Value::of(spectrum.star_temperature_k);
        out.member("table_temperature_k") = Value::of(spectrum.table_temperature_k);
    }
    if (spectrum.modes.empty())
        return;
    Value modes;
    modes.kind = Value::Kind::array;
    for (const double mode : spectrum.modes)
        modes.items.push_back(Value::of(mode));
    out.member("modes") = modes;
}

void set_shift(const Mask &mask, Value &out) {
    Value shift;
    shift.kind = Value::Kind::array;
    for (const double m : mask.shift_m)
        shift.items.push_back(Value::of(m));
    out.member("shift_m") = shift;
}

// Only the sum of jitter and diffusion is a possible covariance at all times: where one of them is none alone, it
// becomes the jitter.
void make_blur_possible(Scene scene, Value &tree) {
    Jitter jitter = scene.systematics.jitter;
    if (scene.detector.diffusion_px2 == 0 || (scene.detector.diffusion_px2 > 0 && !make_possible(jitter)))
        return;
    scene.systematics.jitter = blur_of(scene);
    tree.member("detector").remove("diffusion_px");
    set_jitter(scene, tree.member("systematics"));
}

// Writes the group of a parameter; groups of several parameters more than once.
void set(Parameter parameter, const Scene &scene, Value &tree) {
    Value &telescope = tree.member("telescope"), &detector = tree.member("detector");
    switch (parameter.kind) {
    case Kind::focus:
    case Kind::zernike:
        return set_zernikes(scene, telescope);
    case Kind::mask_rotation:
        telescope.member("mask").member("rotation_deg") = Value::of(scene.telescope.mask.rotation_deg);
        return;
    case Kind::mask_shift_x:
    case Kind::mask_shift_y:
        return set_shift(scene.telescope.mask, telescope.member("mask"));
    case Kind::scale:
        detector.member("pixel_scale_arcsec") = Value::of(scene.detector.pixel_scale_arcsec);
        return;
    case Kind::anisotropy:
        detector.member("scale_anisotropy") = Value::of(scene.detector.scale_anisotropy);
        return;
    case Kind::shear:
        detector.member("shear") = Value::of(scene.detector.shear);
        return;
    case Kind::jitter_xx:
    case Kind::jitter_yy:
    case Kind::jitter_xy:
        return set_jitter(scene, tree.member("systematics"));
    case Kind::diffusion:
        detector.member("diffusion_px") = Value::of(std::sqrt(std::max(0.0, scene.detector.diffusion_px2)));
        return set_jitter(scene, tree.member("systematics"));
    case Kind::transfer_smear:
        detector.member("transfer_smear") = Value::of(scene.detector.transfer_smear);
        return;
    case Kind::brighter_fatter:
        detector.member("brighter_fatter_px2_per_e") = Value::of(scene.detector.brighter_fatter_px2_per_e);
        return;
    case Kind::interpixel_capacitance:
        detector.member("interpixel_capacitance") = Value::of(scene.detector.interpixel_capacitance);
        return;
    case Kind::nonlinearity:
        detector.member("nonlinearity_per_e") = Value::of(scene.detector.nonlinearity_per_e);
        return;
    case Kind::temperature_a:
    case Kind::spectrum_a:
        return set_spectrum(scene, 0, tree.member("stars"));
    default:
        return set_spectrum(scene, 1, tree.member("stars"));
    }
}

// The verdict of a window, unless the calibration is still running.
void add_verdict(const Calibration &calibration, size_t window, Value &group) {
    const bool ended = !calibration.underway;
    const Goodness goodness = ended ? calibration.goodness_of[window] : Goodness();
    group.member("goodness") = Value::of(std::string(toliman::name_of(goodness.verdict)));
    if (ended) {
        group.member("chi_square") = Value::of(goodness.chi_square);
        group.member("chi_square_sigma") = Value::of(goodness.sigma);
        group.member("largest_residual") = Value::of(goodness.largest);
    }
    Value &complete = group.member("complete");
    complete.kind = Value::Kind::boolean;
    complete.boolean = ended && (calibration.flags & (incomplete | too_good)) == 0;
    group.member("frames") = Value::of(static_cast<double>(calibration.windows[window].size()));
}

Value provenance(const Scene &scene) {
    Value group;
    group.member("pupil_samples") = Value::of(static_cast<double>(scene.telescope.pupil_samples));
    if (scene.band && scene.band->steps > 0)
        group.member("step_nm") =
            Value::of((scene.band->max_nm - scene.band->min_nm) / static_cast<double>(scene.band->steps));
    group.member("edges") = Value::of(std::string(scene.telescope.mask.edges == Mask::Edges::area ? "area" : "cell"));
    group.member("accuracy") = Value::of(scene.accuracy);
    return group;
}

// The scene of a window for a file in `folder`: the nominal text with the fitted values. File names that are relative
// stay so. map_file, response_file: names of the OPD map and of the response; "" = none.
std::string fitted_json(const Calibration &calibration, size_t window, const std::string &folder,
                        const std::string &map_file, const std::string &response_file) {
    const Scene scene = fitted_scene(calibration, window);
    Value tree = json::parse(scene.json, scene.source);
    const auto place = [](const std::string &name) { return std::filesystem::absolute(name.empty() ? "." : name); };
    move_files("", tree, place(scene.folder), place(folder));
    for (const Free &free : calibration.free)
        set(free.parameter, scene, tree);
    make_blur_possible(scene, tree);
    if (!map_file.empty())
        tree.member("telescope").member("aberrations").member("opd_file") = Value::of(map_file);
    if (!response_file.empty())
        tree.member("detector").member("response") = Value::of(response_file);
    if ((calibration.improved & lacks_edges) != 0)
        tree.member("telescope").member("mask").member("edges") = Value::of(std::string("area"));
    if ((calibration.improved & lacks_samples) != 0)
        tree.member("telescope").member("pupil_samples") = Value::of(static_cast<double>(calibration.samples));
    Value &group = tree.member("calibration") = provenance(scene);
    add_verdict(calibration, window, group);
    return json::print(tree);
}

// The OPD map of the fitted scene: that of the nominal scene's file, if any, plus the fitted one. [N][N] in m; empty
// without a fitted map.
Buffer<double> fitted_map(const Calibration &calibration) {
    Buffer<double> map = calibration.point.map_m;
    if (map.empty())
        return map;
    const std::vector<double> &before = calibration.nominal_map_m;
    for (size_t i = 0; i < before.size(); i++)
        map[i] += before[i];
    return map;
}

// An array [rows][cols] as the content of an .npy file.
template <class Values> std::string npy_of(const Values &values, size_t rows, size_t cols) {
    std::string text("\x93NUMPY\1\0", 8);
    text += static_cast<char>(kNpyHeader - 10);
    text += '\0';
    text += "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " + std::to_string(cols) +
            "), }";
    text.resize(kNpyHeader - 1, ' ');
    text += '\n';
    text.append(reinterpret_cast<const char *>(values.data()), values.size() * sizeof(double));
    return text;
}

} // namespace

void save_fitted(const Calibration &calibration, size_t window, const std::string &name) {
    constexpr char suffix[] = ".json";
    const size_t length = sizeof suffix - 1;
    if (name.size() <= length || name.compare(name.size() - length, length, suffix) != 0)
        fail(Status::argument, "{path} = \"%s\": must end with .json", name.c_str());
    if ((calibration.flags & not_converged) != 0)
        fail(Status::unsupported, "{calibration} did not converge: there is no fitted scene");
    const size_t slash = name.rfind('/');
    const std::string folder = slash == std::string::npos ? "." : name.substr(0, slash + 1),
                      stem = name.substr(0, name.size() - length);
    const auto write = [&](const char *kind, const auto &values, size_t rows, size_t cols, const std::string &given) {
        const std::string path = stem + kind;
        std::error_code different;
        if (!given.empty() && std::filesystem::equivalent(path, given, different))
            fail(Status::argument, "{path} = \"%s\": its %s would replace %s of the nominal scene", name.c_str(),
                 path.c_str(), given.c_str());
        const std::string bytes = npy_of(values, rows, cols);
        file::replace(path, bytes.data(), bytes.size());
        return slash == std::string::npos ? path : path.substr(slash + 1);
    };
    const Scene &nominal = calibration.nominal;
    std::string map_file, response_file;
    if (const Buffer<double> map = fitted_map(calibration); !map.empty())
        map_file = write(".opd.npy", map, calibration.samples, calibration.samples, nominal.telescope.opd_file);
    if (!calibration.point.response.empty())
        response_file = write(".response.npy", fitted_response(calibration), nominal.detector.rows,
                              nominal.detector.cols, nominal.detector.response_file);
    const std::string json = fitted_json(calibration, window, folder, map_file, response_file);
    file::replace(name, json.data(), json.size());
}

} // namespace toliman::calibrate
