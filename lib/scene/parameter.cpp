#include "scene/parameter.hpp"

#include <algorithm>

namespace toliman {

namespace {

struct Row {
    Parameter::Kind kind;
    const char *name, *unit;
    Scope scope;
    int first = 0, last = 0; // of the numbers that the names end with
};

using Kind = Parameter::Kind;
// In the order of Kind.
constexpr Row kRows[] = {
    {Kind::separation, "separation", "px", Scope::frame},
    {Kind::position_angle, "position_angle", "rad", Scope::frame},
    {Kind::shift_x, "shift_x", "px", Scope::frame},
    {Kind::shift_y, "shift_y", "px", Scope::frame},
    {Kind::roll, "roll", "rad", Scope::frame},
    {Kind::flux_a, "flux_a", "", Scope::frame},
    {Kind::flux_b, "flux_b", "", Scope::frame},
    {Kind::background, "background", "photons", Scope::frame},
    {Kind::scale, "scale", "", Scope::instrument},
    {Kind::anisotropy, "anisotropy", "", Scope::instrument},
    {Kind::shear, "shear", "", Scope::instrument},
    {Kind::focus, "focus", "nm", Scope::instrument},
    {Kind::zernike, "zernike", "nm", Scope::instrument, kFirstZernike, kLastZernike},
    {Kind::mask_rotation, "mask_rotation", "deg", Scope::instrument},
    {Kind::mask_shift_x, "mask_shift_x", "m", Scope::instrument},
    {Kind::mask_shift_y, "mask_shift_y", "m", Scope::instrument},
    {Kind::jitter_xx, "jitter_xx", "px^2", Scope::frame},
    {Kind::jitter_yy, "jitter_yy", "px^2", Scope::frame},
    {Kind::jitter_xy, "jitter_xy", "px^2", Scope::frame},
    {Kind::temperature_a, "temperature_a", "K", Scope::instrument},
    {Kind::temperature_b, "temperature_b", "K", Scope::instrument},
    {Kind::spectrum_a, "spectrum_a", "", Scope::instrument, 1, kSpectralModes},
    {Kind::spectrum_b, "spectrum_b", "", Scope::instrument, 1, kSpectralModes},
    {Kind::wavelength, "wavelength", "nm", Scope::instrument},
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
