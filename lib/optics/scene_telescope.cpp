#include <charconv>
#include <cmath>

#include "kernels/zernike.hpp"
#include "optics/scene_groups.hpp"

namespace toliman::optics {

namespace {

constexpr double kNanometre = 1e-9;
constexpr Range kMaskOpd = above(0, 1e6, "nm");

// The OPD of a mask's step: given directly, or as the height of a stepped mirror, whose OPD is twice the height.
double read_step_m(const Reader &mask) {
    if (mask.has("opd_nm") == mask.has("height_nm"))
        mask.refuse(Status::scene, "opd_nm", ": give either opd_nm or height_nm");
    return mask.has("opd_nm") ? mask.number("opd_nm", kMaskOpd) * kNanometre
                              : 2 * mask.number("height_nm", kMaskOpd) * kNanometre;
}

// The mask's step is where sum over the terms of a cos(2 pi f r + l ln r + m theta + p) > 0, r in units of the
// aperture's radius.
std::vector<SpiralTerm> read_terms(const Reader &mask) {
    const Range free = within(-1e4, 1e4, "");
    std::vector<SpiralTerm> terms;
    for (const Reader &term : mask.objects("terms", 1, 64)) {
        term.allow({"a", "f", "l", "m", "p"});
        terms.push_back({term.number("a", free), term.number_or("f", 0, free), term.number_or("l", 0, free),
                         static_cast<double>(term.has("m") ? term.integer("m", free) : 0),
                         term.number_or("p", 0, free)});
    }
    return terms;
}

Mask read_file_mask(const Reader &reader, const std::string &folder) {
    Mask mask;
    mask.kind = Mask::Kind::file;
    mask.quantity = static_cast<Mask::Quantity>(reader.choice("quantity", {"binary", "opd_m", "phase_rad"}));
    mask.file = reader.file("file", folder);
    if (mask.quantity != Mask::Quantity::phase_rad)
        reader.exclude({"reference_nm"}, "needs quantity \"phase_rad\"");
    if (mask.quantity != Mask::Quantity::binary)
        reader.exclude({"opd_nm", "height_nm"}, "needs quantity \"binary\"");
    switch (mask.quantity) {
    case Mask::Quantity::binary:
        reader.allow({"kind", "file", "quantity", "opd_nm", "height_nm"});
        mask.opd_m = read_step_m(reader);
        break;
    case Mask::Quantity::opd_m:
        reader.allow({"kind", "file", "quantity"});
        break;
    case Mask::Quantity::phase_rad:
        reader.allow({"kind", "file", "quantity", "reference_nm"});
        mask.reference_m = reader.number("reference_nm", above(0, 1e6, "nm")) * kNanometre;
        break;
    }
    return mask;
}

Mask read_mask(const Reader &telescope, const std::string &folder) {
    Mask mask;
    if (!telescope.has("mask"))
        return mask;
    const Reader reader = telescope.object("mask");
    mask.kind = static_cast<Mask::Kind>(reader.choice("kind", {"clear", "spiral", "file"}));
    if (mask.kind != Mask::Kind::spiral)
        reader.exclude({"terms"}, "needs kind \"spiral\"");
    if (mask.kind != Mask::Kind::file)
        reader.exclude({"file", "quantity", "reference_nm"}, "needs kind \"file\"");
    switch (mask.kind) {
    case Mask::Kind::clear:
        reader.exclude({"opd_nm", "height_nm"}, "needs kind \"spiral\" or \"file\"");
        reader.allow({"kind"});
        break;
    case Mask::Kind::spiral:
        reader.allow({"kind", "opd_nm", "height_nm", "terms"});
        mask.opd_m = read_step_m(reader);
        mask.terms = read_terms(reader);
        break;
    case Mask::Kind::file:
        return read_file_mask(reader, folder);
    }
    return mask;
}

Struts read_struts(const Reader &telescope, double aperture_m) {
    Struts struts;
    if (!telescope.has("struts"))
        return struts;
    const Reader reader = telescope.object("struts");
    reader.allow({"count", "width_m", "angle_deg"});
    struts.count = static_cast<int>(reader.integer("count", within(0, 16, "struts")));
    struts.width_m = reader.number("width_m", within(0, aperture_m, "m"));
    struts.angle_deg = reader.number_or("angle_deg", 0, within(-360, 360, "deg"));
    return struts;
}

// Parses a key of zernike_rms_nm, a Noll index in decimal digits without leading zeros.
int read_noll(const Reader &zernikes, const std::string &key) {
    int noll = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), noll);
    if (error != std::errc() || end != key.data() + key.size() || std::to_string(noll) != key || noll < 1 ||
        noll > kernels::kLargestNoll)
        zernikes.refuse(Status::scene, key.c_str(), ": unknown key; must be a Noll index from 1 to %d",
                        kernels::kLargestNoll);
    return noll;
}

void read_aberrations(const Reader &reader, const std::string &folder, Telescope &telescope) {
    reader.allow({"zernike_rms_nm", "opd_file"});
    if (reader.has("opd_file"))
        telescope.opd_file = reader.file("opd_file", folder);
    if (!reader.has("zernike_rms_nm"))
        return;
    const Reader zernikes = reader.object("zernike_rms_nm");
    for (const std::string &key : zernikes.names())
        telescope.zernikes.push_back(
            {read_noll(zernikes, key), zernikes.number(key.c_str(), within(-1e6, 1e6, "nm")) * kNanometre});
}

} // namespace

Telescope read_telescope(const Reader &scene, const std::string &folder) {
    const Reader reader = scene.object("telescope");
    reader.allow({"aperture_m", "secondary_m", "struts", "pupil_samples", "amplitude", "mask", "aberrations"});
    Telescope telescope;
    telescope.aperture_m = reader.number("aperture_m", within(1e-3, 100, "m"));
    telescope.secondary_m = reader.number_or("secondary_m", 0, within(0, 100, "m"));
    if (telescope.secondary_m >= telescope.aperture_m)
        reader.refuse(Status::scene, "secondary_m", " = %g: must be less than aperture_m = %g m", telescope.secondary_m,
                      telescope.aperture_m);
    telescope.struts = read_struts(reader, telescope.aperture_m);
    if (reader.has("pupil_samples"))
        telescope.pupil_samples =
            static_cast<size_t>(reader.integer("pupil_samples", within(8, kMostPupilSamples, "samples")));
    if (reader.has("amplitude")) {
        const Reader amplitude = reader.object("amplitude");
        amplitude.allow({"file"});
        telescope.amplitude_file = amplitude.file("file", folder);
    }
    telescope.mask = read_mask(reader, folder);
    if (reader.has("aberrations"))
        read_aberrations(reader.object("aberrations"), folder, telescope);
    return telescope;
}

} // namespace toliman::optics
