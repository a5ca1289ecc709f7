#include "scene/parameter.hpp"

#include <algorithm>

namespace toliman {

namespace {

struct Row {
    const char *name, *unit;
    Parameter::Kind kind;
    Scope scope;
    int first = 0, last = 0; // of the numbers that the names end with
};

using Kind = Parameter::Kind;
// In the order of Kind.
constexpr Row kRows[] = {
    {"separation", "px", Kind::separation, Scope::frame},
    {"position_angle", "rad", Kind::position_angle, Scope::frame},
    {"shift_x", "px", Kind::shift_x, Scope::frame},
    {"shift_y", "px", Kind::shift_y, Scope::frame},
    {"roll", "rad", Kind::roll, Scope::frame},
    {"flux_a", "", Kind::flux_a, Scope::frame},
    {"flux_b", "", Kind::flux_b, Scope::frame},
    {"background", "photons", Kind::background, Scope::frame},
    {"scale", "", Kind::scale, Scope::instrument},
    {"anisotropy", "", Kind::anisotropy, Scope::instrument},
    {"shear", "", Kind::shear, Scope::instrument},
    {"focus", "nm", Kind::focus, Scope::instrument},
    {"zernike", "nm", Kind::zernike, Scope::instrument, kFirstZernike, kLastZernike},
    {"mask_rotation", "deg", Kind::mask_rotation, Scope::instrument},
    {"mask_shift_x", "m", Kind::mask_shift_x, Scope::instrument},
    {"mask_shift_y", "m", Kind::mask_shift_y, Scope::instrument},
    {"jitter_xx", "px^2", Kind::jitter_xx, Scope::frame},
    {"jitter_yy", "px^2", Kind::jitter_yy, Scope::frame},
    {"jitter_xy", "px^2", Kind::jitter_xy, Scope::frame},
    {"temperature_a", "K", Kind::temperature_a, Scope::instrument},
    {"temperature_b", "K", Kind::temperature_b, Scope::instrument},
    {"spectrum_a", "", Kind::spectrum_a, Scope::instrument, 1, kSpectralModes},
    {"spectrum_b", "", Kind::spectrum_b, Scope::instrument, 1, kSpectralModes},
    {"wavelength", "nm", Kind::wavelength, Scope::instrument},
    {"diffusion", "px^2", Kind::diffusion, Scope::instrument},
    {"transfer_smear", "", Kind::transfer_smear, Scope::instrument},
    {"brighter_fatter", "px^2/e-", Kind::brighter_fatter, Scope::instrument},
    {"interpixel_capacitance", "", Kind::interpixel_capacitance, Scope::instrument},
    {"nonlinearity", "1/e-", Kind::nonlinearity, Scope::instrument},
    {"flat", "", Kind::flat, Scope::instrument},
    {"smear", "px^2", Kind::smear, Scope::frame},
};

const Row &row_of(Parameter parameter) noexcept {
    return kRows[static_cast<size_t>(parameter.kind)];
}

} // namespace

std::string name_of(Parameter parameter) {
    const Row &row = row_of(parameter);
    return row.last == 0 ? row.name : row.name + ("_" + std::to_string(parameter.number));
}

const char *unit_of(Parameter parameter) noexcept {
    return row_of(parameter).unit;
}

Scope scope_of(Parameter parameter) noexcept {
    return row_of(parameter).scope;
}

size_t parameter_count() noexcept {
    size_t count = 0;
    for (const Row &row : kRows)
        count += static_cast<size_t>(row.last - row.first + 1);
    return count;
}

const std::vector<Parameter> &all_parameters() {
    static const std::vector<Parameter> all = [] {
        std::vector<Parameter> list;
        for (const Row &row : kRows)
            for (int number = row.first; number <= row.last; number++)
                list.push_back({row.kind, number});
        return list;
    }();
    return all;
}

std::optional<Parameter> parameter_named(const std::string &name) {
    const std::vector<Parameter> &all = all_parameters();
    const auto found = std::find_if(all.begin(), all.end(), [&](Parameter p) { return name_of(p) == name; });
    return found != all.end() ? std::optional<Parameter>(*found) : std::nullopt;
}

} // namespace toliman
