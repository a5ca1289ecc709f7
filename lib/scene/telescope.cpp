#include <algorithm>

#include "scene/groups.hpp"
#include "scene/noll.hpp"

namespace toliman::scene {

namespace {

constexpr double kNanometre = 1e-9;
constexpr Range kFree = within(-1e4, 1e4);
constexpr Condition kIsSpiral = is("kind", "spiral"), kIsFile = is("kind", "file");

void check_secondary(const Reader &reader, const Telescope &telescope) {
    if (telescope.secondary_m >= telescope.aperture_m)
        reader.refuse(Status::scene, "secondary_m", " = %g: must be less than aperture_m = %g m", telescope.secondary_m,
                      telescope.aperture_m);
}

void read_width(const Reader &reader, const Row &row, Struts &struts) {
    struts.width_m = reader.number(row.key, within(0, reader.scene().telescope.aperture_m, "m"));
}

constexpr Row kTermRows[] = {
    required<&SpiralTerm::a>("a", kFree, "Amplitude"),
    optional<&SpiralTerm::f>("f", kFree, "Cycles per radius"),
    optional<&SpiralTerm::l>("l", kFree, "Radians per ln r"),
    optional<&SpiralTerm::m>("m", kFree, "Cycles per turn").as(Type::integer),
    optional<&SpiralTerm::p>("p", kFree, "Phase in rad"),
};
constexpr Group kTerm = group_of("term",
                                 "a cos(2 pi f r + l ln r + m theta + p), where r is in units of the aperture's radius "
                                 "and theta is measured from +x towards +y",
                                 kTermRows);

void read_terms(const Reader &reader, const Row &row, Mask &mask) {
    for (const Reader &term : reader.objects(row))
        read_group(kTerm, term, &mask.terms.emplace_back());
}

void read_shift(const Reader &reader, const Row &row, Mask &mask) {
    const std::vector<double> shift = reader.numbers(row);
    std::copy(shift.begin(), shift.end(), mask.shift_m);
}

// The OPD of a step is given directly, or as the height of a stepped mirror, whose OPD is twice the height.
constexpr Row kMaskRows[] = {
    required<&Mask::kind>(
        "kind", Words{"clear spiral file"},
        "clear: no mask; spiral: a step where a sum of spiral cosines is positive; file: a map from a file"),
    required<&Mask::quantity>(
        "quantity", Words{"binary opd_m phase_rad"},
        "Quantity in the map; binary: 0 and 1, with opd_nm or height_nm; phase_rad: with reference_nm")
        .when(kIsFile),
    required<&Mask::file>("file",
                          ".npy (from FITS: toliman convert) of float32, float64, uint8 or bool, pupil_samples x "
                          "pupil_samples")
        .when(kIsFile),
    optional<&Mask::edges>("edges", Words{"cell area"},
                           "Step in a pupil cell that an edge crosses; cell: that of the cell's centre, discontinuous "
                           "in rotation and shift; area: the transmission averaged over the cell's area")
        .when(kIsSpiral),
    optional<&Mask::rotation_deg>("rotation_deg", kTurn, "Rotation about the mask's centre, from +x towards +y")
        .when(kIsSpiral),
    optional<read_shift>("shift_m", within(-0.1, 0.1, "m"), "[x, y] of the mask's centre, after the rotation")
        .as(Type::numbers)
        .entries(2, 2)
        .when(kIsSpiral),
    required<read_terms>("terms", &kTerm, "Terms of the sum").as(Type::groups).entries(1, 64).when(kIsSpiral),
    required<&Mask::opd_nm>("opd_nm", above(0, 1e6, "nm"), "OPD of the step")
        .either("height_nm")
        .when(is("kind", "spiral file"), is("quantity", "binary")),
    optional<&Mask::height_nm>("height_nm", above(0, 1e6, "nm"),
                               "Height of a stepped mirror; the OPD is twice the height")
        .when(is("kind", "spiral file"), is("quantity", "binary")),
    required<&Mask::reference_m>("reference_nm", above(0, 1e6, "nm"), "Wavelength of the phase")
        .scaled(kNanometre)
        .when(kIsFile, is("quantity", "phase_rad")),
};
constexpr Group kMask = group_of("mask", "Phase mask", kMaskRows);

constexpr Row kStrutRows[] = {
    required<&Struts::count>("count", within(0, 16, "struts"), "Number of struts"),
    required<read_width>("width_m", within(0, 100, "m"), "Width; at most aperture_m"),
    optional<&Struts::angle_deg>("angle_deg", kTurn,
                                 "Angle of the first strut, from +x (higher columns) towards +y (higher rows)"),
};
constexpr Group kStruts = group_of("struts", "Struts from the centre to the rim, at equal angles", kStrutRows);

constexpr Row kAmplitudeRows[] = {
    required<&Telescope::amplitude_file>("file", ".npy of 0 to 1, pupil_samples x pupil_samples"),
};
constexpr Group kAmplitude = group_of("amplitude",
                                      "Amplitude transmission of the pupil, multiplies the aperture; absorbed light "
                                      "does not count as light of the star",
                                      kAmplitudeRows);

void read_zernikes(const Reader &reader, const Row &row, Telescope &telescope) {
    const Reader zernikes = reader.object(row.key);
    for (const std::string &key : zernikes.names())
        telescope.zernikes.push_back({noll_of(zernikes, key, 1), zernikes.number(key.c_str(), row.range) * row.scale});
}

constexpr Row kAberrationRows[] = {
    optional<&Telescope::opd_file>("opd_file", "OPD map: .npy in m, -1e-3 to 1e-3, pupil_samples x pupil_samples"),
    optional<read_zernikes>("zernike_rms_nm", within(-1e6, 1e6, "nm"),
                            "Zernike coefficients by Noll index, rms over the full aperture; 2 and 3 tilt, 4 defocus")
        .as(Type::numbers_by_index)
        .entries(1, kernels::kLargestNoll)
        .scaled(kNanometre),
};
constexpr Group kAberrations = group_of("aberrations", "Aberrations: added to the mask's OPD", kAberrationRows);

void read_throughput(const Reader &reader, const Row &row, Telescope &telescope) {
    for (const NumberOrFile &one : reader.numbers_and_files(row))
        telescope.throughput.push_back({one.file.empty() ? one.number : 1, one.file});
}

constexpr Row kTelescopeRows[] = {
    required<&Telescope::aperture_m>("aperture_m", within(1e-3, 100, "m"), "Diameter of the aperture"),
    optional<&Telescope::secondary_m>("secondary_m", within(0, 100, "m"),
                                      "Diameter of the central obstruction; less than aperture_m")
        .checked<check_secondary>(),
    optional<&Telescope::struts>("struts", &kStruts),
    optional<&Telescope::pupil_samples>("pupil_samples", within(8, kMostPupilSamples, "samples"),
                                        "Samples across the aperture; at least 2 R D / wavelength, where R is the "
                                        "angle from a star to the farthest side of the frame; otherwise the image "
                                        "would be aliased"),
    part("amplitude", &kAmplitude),
    optional<&Telescope::mask>("mask", &kMask),
    part("aberrations", &kAberrations),
    optional<read_throughput>(
        "throughput", above(0, 1),
        "Factors of the light of all stars: filter, mirrors, windows, once per surface. Each is a "
        "number, or a file with wavelength and throughput, which must cover the band")
        .as(Type::numbers_and_files)
        .entries(1, 64),
};

} // namespace

constexpr Group kTelescope = group_of("telescope", "Telescope", kTelescopeRows);

} // namespace toliman::scene
