#include "optics/stages.hpp"

namespace toliman::optics {

namespace {

struct Stage {
    const char *name;
    bool (*is_modelled)(const Scene &);
};

const Stage kAllStages[kStages] = {
    {"second star", [](const Scene &scene) { return scene.stars.size() > 1; }},
    {"spectrum", [](const Scene &scene) { return !scene.band || scene.band->steps > 0; }},
    {"mask", [](const Scene &scene) { return scene.telescope.mask.kind != Mask::Kind::clear; }},
    {"struts", [](const Scene &scene) { return scene.telescope.struts.count > 0; }},
    {"aberrations",
     [](const Scene &scene) { return !scene.telescope.zernikes.empty() || !scene.telescope.opd_file.empty(); }},
    {"signal", [](const Scene &scene) { return scene.signal.amplitude_px != 0; }},
    {"pixel integration", [](const Scene &scene) { return scene.detector.integrated; }},
    {"photon noise", [](const Scene &scene) { return scene.noise.photon; }},
    {"read noise", [](const Scene &scene) { return scene.noise.read_e != 0; }},
    {"quantum efficiency",
     [](const Scene &scene) { return scene.detector.qe != 1 || !scene.detector.qe_file.empty(); }},
    {"charge diffusion", [](const Scene &scene) { return scene.detector.diffusion_px2 != 0; }},
    {"transfer smear", [](const Scene &scene) { return scene.detector.transfer_smear != 0; }},
    {"brighter-fatter", [](const Scene &scene) { return scene.detector.brighter_fatter_px2_per_e != 0; }},
    {"interpixel capacitance", [](const Scene &scene) { return scene.detector.interpixel_capacitance != 0; }},
    {"non-linearity", [](const Scene &scene) { return scene.detector.nonlinearity_per_e != 0; }},
    {"flat field", [](const Scene &scene) { return scene.detector.flat_rms != 0 || !scene.detector.response.empty(); }},
    {"dark current", [](const Scene &scene) { return scene.detector.dark_e_per_s != 0; }},
    {"full well", [](const Scene &scene) { return scene.detector.full_well_e.has_value(); }},
    {"gain and bias",
     [](const Scene &scene) { return scene.detector.gain_e_per_dn != 1 || scene.detector.bias_dn != 0; }},
    {"bit depth", [](const Scene &scene) { return scene.detector.bit_depth != 0; }},
    {"jitter", [](const Scene &scene) { return scene.systematics.jitter.any(); }},
    {"systematics", [](const Scene &scene) { return scene.systematics.any(); }},
    {"moving stars",
     [](const Scene &scene) {
         return scene.binary.moving || scene.systematics.pointing_px.any() || scene.systematics.roll_rad.any();
     }},
    {"smear", [](const Scene &scene) { return scene.systematics.smear && scene.systematics.smear->length_px > 0; }},
    {"sidelobe", [](const Scene &scene) { return scene.detector.sidelobe.has_value(); }},
};

} // namespace

const char *stage_name(size_t stage) noexcept {
    return kAllStages[stage].name;
}

bool has_stage(const Scene &scene, size_t stage) noexcept {
    return kAllStages[stage].is_modelled(scene);
}

} // namespace toliman::optics
