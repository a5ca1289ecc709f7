// Method: the change q of a parameter against the nominal scene has a normal prior around 0, which adds q^2/sigma^2 to
// the sum of squares (solve.cpp). With several windows, this is the prior of the first one.
// The default priors are wider than the as-built errors of a small telescope, so that they hold parameters in place
// that the frames do not determine, and do not bias those that they do.
#include "calibrate/prior.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/nearest_word.hpp"
#include "base/words.hpp"
#include "optics/derivatives.hpp"
#include "scene/instrument.hpp"

namespace toliman::calibrate {

namespace {

using Kind = Parameter::Kind;

// One item of the text.
struct Item {
    std::string name;
    int last = 0; // of a range of numbers; 0 = none
    double sigma = 0;
};

[[noreturn]] void refuse(const std::string &item, const char *why) {
    fail(Status::argument, "{options->free}: \"%s\": %s", item.substr(0, 60).c_str(), why);
}

Item parse(const std::string &text) {
    Item item;
    const size_t equals = text.find('=');
    if (equals != std::string::npos) {
        const char *const number = text.c_str() + equals + 1, *const last = text.c_str() + text.size();
        const auto [end, error] = std::from_chars(number, last, item.sigma); // in any locale
        if (error != std::errc() || end != last || !(item.sigma > 0) || !std::isfinite(item.sigma))
            refuse(text, "the standard deviation of a prior must be a number above 0");
    }
    item.name = text.substr(0, equals);
    const size_t dash = item.name.find('-');
    if (dash == std::string::npos)
        return item;
    const std::string last = item.name.substr(dash + 1);
    const auto [end, error] = std::from_chars(last.data(), last.data() + last.size(), item.last);
    if (error != std::errc() || end != last.data() + last.size() || item.last <= 0)
        refuse(text, "must end with a number, as zernike_5-21");
    item.name.resize(dash);
    return item;
}

Parameter parameter_of(const std::string &name) {
    if (const std::optional<Parameter> found = parameter_named(name))
        return *found;
    std::vector<std::string> names;
    for (const Parameter parameter : all_parameters())
        names.push_back(name_of(parameter));
    const std::string nearest = nearest_word(name, names);
    fail(Status::argument, "{options->free}: \"%s\": must be the name of a parameter%s%s%s", name.substr(0, 40).c_str(),
         nearest.empty() ? "" : "; did you mean \"", nearest.c_str(), nearest.empty() ? "" : "\"?");
}

std::vector<Parameter> range_of(const std::string &text, const Item &item) {
    const Parameter first = parameter_of(item.name);
    std::vector<Parameter> range = {first};
    if (item.last == 0)
        return range;
    if (first.number == 0 || item.last <= first.number)
        refuse(text, "a range must go from a number to a larger one, as zernike_5-21");
    for (int number = first.number + 1; number <= item.last; number++)
        range.push_back(parameter_of(name_of({first.kind, number})));
    return range;
}

bool is_always_free(Kind kind) noexcept {
    return kind == Kind::separation || kind == Kind::shift_x || kind == Kind::shift_y || kind == Kind::flux_a ||
           kind == Kind::flux_b || kind == Kind::background;
}

void add(const std::string &text, const Item &item, const Scene &scene, const optics::Plan &plan, double peak_e,
         bool named, std::vector<Free> &all, std::vector<LeftOut> *left_out) {
    for (const Parameter parameter : range_of(text, item)) {
        if (const char *const why = why_not_adjustable(parameter))
            fail(is_always_free(parameter.kind) ? Status::argument : Status::unsupported, "{options->free}: \"%s\": %s",
                 name_of(parameter).c_str(), why);
        if (const char *const why = optics::why_no_derivative(scene, plan, parameter)) {
            if (!named) {
                if (left_out != nullptr)
                    left_out->push_back({parameter, why});
                continue;
            }
            fail(Status::unsupported, "%s: {options->free}: \"%s\": %s", scene.source.c_str(),
                 name_of(parameter).c_str(), why);
        }
        if (std::any_of(all.begin(), all.end(), [=](const Free &one) { return one.parameter == parameter; }))
            refuse(name_of(parameter), "must be named once");
        all.push_back({parameter, item.sigma != 0 ? item.sigma : default_sigma(parameter, peak_e)});
    }
}

bool is_added(const std::string &item) noexcept {
    return item[0] == '+';
}

// Diffusion adds to the variance of the jitter in x and in y.
void check_blur(const std::vector<Free> &all) {
    const auto has = [&all](Kind kind) {
        return std::any_of(all.begin(), all.end(), [=](const Free &one) { return one.parameter.kind == kind; });
    };
    if (has(Kind::diffusion) && (has(Kind::jitter_xx) || has(Kind::jitter_yy)))
        fail(Status::argument, "{options->free}: \"diffusion\": blurs as jitter_xx and jitter_yy do together: name it "
                               "instead of both");
}

} // namespace

const char *const kDefaultParameters = "focus zernike_5-21 scale mask_rotation jitter_xx jitter_yy jitter_xy "
                                       "temperature_a temperature_b spectrum_a_1-2 spectrum_b_1-2";

double default_sigma(Parameter parameter, double peak_e) noexcept {
    switch (parameter.kind) {
    case Kind::focus:
    case Kind::zernike:
        return 100; // nm
    case Kind::mask_rotation:
        return 1; // deg
    case Kind::mask_shift_x:
    case Kind::mask_shift_y:
        return 1e-4; // m
    case Kind::jitter_xx:
    case Kind::jitter_yy:
    case Kind::jitter_xy:
        return 0.1; // px^2
    case Kind::temperature_a:
    case Kind::temperature_b:
        return 200; // K
    case Kind::spectrum_a:
    case Kind::spectrum_b:
        return 0.1;
    case Kind::diffusion:
        return 0.1; // px^2
    case Kind::brighter_fatter:
    case Kind::nonlinearity:
        return 0.1 / peak_e; // px^2, and share, of the brightest pixel
    default:
        return 1e-2; // scale, anisotropy, shear, transfer_smear, interpixel_capacitance
    }
}

std::string with_readout(const std::string &text, bool sums) {
    std::string all = text;
    const std::vector<std::string> items = words_of(text);
    if (!std::all_of(items.begin(), items.end(), is_added))
        return text;
    for (const Kind kind :
         {Kind::transfer_smear, Kind::interpixel_capacitance, Kind::nonlinearity, Kind::brighter_fatter}) {
        const std::string name = name_of({kind});
        const bool is_named = std::any_of(items.begin(), items.end(),
                                          [&](const std::string &item) { return parse(item.substr(1)).name == name; });
        if (!is_named && (!sums || kind == Kind::transfer_smear || kind == Kind::interpixel_capacitance))
            all += " +" + name;
    }
    return all;
}

std::vector<Free> free_of(const std::string &text, const Scene &scene, const optics::Plan &plan, double peak_e,
                          std::vector<LeftOut> *left_out) {
    const std::vector<std::string> items = words_of(text);
    const bool adds = std::all_of(items.begin(), items.end(), is_added); // also if there are none
    if (!adds && std::any_of(items.begin(), items.end(), is_added))
        refuse(text, "all names or none begin with +, which adds to the default parameters");
    std::vector<Free> all, added;
    for (const std::string &item : adds ? words_of(kDefaultParameters) : items)
        add(item, parse(item), scene, plan, peak_e, !adds, all, left_out);
    for (size_t i = 0; adds && i < items.size(); i++)
        add(items[i], parse(items[i].substr(1)), scene, plan, peak_e, true, added, left_out);
    for (const Free &one : added) { // one of the default parameters gets another prior
        const auto same =
            std::find_if(all.begin(), all.end(), [&](const Free &other) { return other.parameter == one.parameter; });
        if (same != all.end())
            same->sigma = one.sigma;
        else
            all.push_back(one);
    }
    check_blur(all);
    return all;
}

} // namespace toliman::calibrate
