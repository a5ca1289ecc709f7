// toliman refit: the orbit of a binary, fitted again to measured separations.
#include "downlink/state_folder.hpp"
#include "options/command.hpp"
#include "series/goodness.hpp"
#include "series/reduction.hpp"
#include "series/series.hpp"

namespace cli {

namespace {

struct RefitOptions {
    std::string system, series, out;
    ReductionOptions reduction;
    SampleOptions samples;
    double scale_sigma = 0;
    bool as_json = false;
};

struct Element {
    const char *name;
    double before, after;             // values
    double sigma_before, sigma_after; // standard deviations, 0 = unknown: the value is kept
    double change() const { return (after - before) / sigma_before; }
};

struct Fitted {
    toliman::sky_predictor sky;
    toliman_sky_refit_result result;
    std::vector<Element> elements;
    int64_t measurements, unreduced;
    std::optional<Json> diagnosis;
};

std::vector<Element> elements_of(const toliman_sky *before, const toliman_sky *after) {
    std::vector<Element> elements(TOLIMAN_SKY_ELEMENTS);
    for (int32_t i = 0; i < static_cast<int32_t>(TOLIMAN_SKY_ELEMENTS); i++) {
        Element &element = elements[static_cast<size_t>(i)];
        const int32_t constant = TOLIMAN_SKY_ELEMENT_PERIOD + i;
        element.name = toliman_constant_name(constant);
        toliman::check(toliman_sky_get_element(before, constant, &element.before, &element.sigma_before));
        toliman::check(toliman_sky_get_element(after, constant, &element.after, &element.sigma_after));
    }
    return elements;
}

// The frames of a state folder have their own times and exposures.
void check_folder_options(const RefitOptions &options) {
    const SampleOptions &samples = options.samples;
    const std::string exposure = options.reduction.exposure ? formatted("%g", *options.reduction.exposure) : "";
    const std::pair<const char *, std::string> given[] = {{"--columns ", samples.columns},
                                                          {"--time-format ", samples.time_format},
                                                          {"--time-scale ", samples.time_scale},
                                                          {"--exposure ", exposure},
                                                          {"--on-target ", options.reduction.on_target}};
    for (const auto &[name, value] : given)
        if (!value.empty())
            throw Failure(kExitUsage, name + value + ": must not be given with a state folder, " + options.series);
}

toliman::measurements measured_of(RefitOptions &options, Progress &progress) {
    if (is_folder(options.series)) {
        check_folder_options(options);
        toliman::measurements measured = measured_frames(options.series, options.reduction.plate_scale, progress);
        options.reduction.plate_scale = info_of(measured.get()).unit;
        options.reduction.of_folder = true;
        return measured;
    }
    const toliman::measurements series = read_series(options.series, options.samples, progress);
    if (info_of(series.get()).is_weighted == 0)
        malformed(name_of(series.get()), "has no column sigma: must have the standard deviation of each separation");
    return separations_of(series.get(), options.reduction);
}

Fitted fit(RefitOptions &options, Progress &progress) {
    const auto sky = options.reduction.observer.predictor(options.system, 0, progress);
    const toliman::measurements measured = measured_of(options, progress);
    const Reduced reduced = reduce(measured.get(), options.reduction, sky.get(), options.scale_sigma, false, progress);
    Fitted fitted = {nullptr,
                     toliman::sized<toliman_sky_refit_result>(),
                     {},
                     info_of(reduced.series.get()).n,
                     reduced.left_out,
                     diagnosis_of(measured.get(), sky.get(), options.scale_sigma, progress)};
    fitted.sky = toliman::make<toliman::sky_predictor>(toliman_sky_refit, sky.get(), measured.get(),
                                                       options.scale_sigma, &fitted.result);
    fitted.elements = elements_of(sky.get(), fitted.sky.get());
    return fitted;
}

void save(const toliman_sky *sky, const std::string &path) {
    OutputFile out(path);
    toliman::check(toliman_sky_save_file(sky, out.hand_over().c_str()));
    out.take_back();
    out.commit();
}

bool is_unusable(const Fitted &fitted) {
    return (fitted.result.flags & TOLIMAN_SKY_UNUSABLE) != 0;
}

void warn(const Fitted &fitted, Progress &progress) {
    warn_of_fit(fitted.result, progress);
    warn_of_outliers(fitted.result.outliers, " disturb the fit", progress);
}

void print_fit_table(const RefitOptions &options, const Fitted &fitted) {
    std::string text = "# system    " + options.system + "\n";
    text += "# observer  " + options.reduction.observer.text() + "\n";
    text += formatted("# samples   %lld, %lld left out\n", static_cast<long long>(fitted.measurements),
                      static_cast<long long>(fitted.unreduced));
    text += formatted("%-17s  %16s  %16s  %12s  %9s\n", "element", "before", "after", "sigma", "change");
    for (const Element &element : fitted.elements) {
        text += formatted("%-17s  %16.10g  %16.10g", element.name, element.before, element.after);
        text += element.sigma_before > 0 ? formatted("  %12.3g  %+9.2f\n", element.sigma_after, element.change())
                                         : formatted("  %12s  %9s\n", "-", "-");
    }
    text += "residuals   " + fit_text(fitted.result) + "\n";
    if (fitted.result.jitter_arcsec > 0)
        text += formatted("jitter      %.4g uas\n", fitted.result.jitter_arcsec * 1e6);
    if (fitted.result.outliers > 0)
        text += formatted("outliers    %u\n", fitted.result.outliers);
    text += formatted("rms         %.4g uas\n", fitted.result.rms_arcsec * 1e6);
    text += formatted("scale       %.3g +- %.2g\n", fitted.result.scale, fitted.result.scale_sigma);
    print_stdout(text);
}

void print_fit_json(const RefitOptions &options, const Fitted &fitted) {
    const toliman_sky_refit_result &result = fitted.result;
    Json json("schema", "toliman-refit/1", "version", toliman_version(), "system", options.system);
    options.reduction.set(json);
    json.set("n", fitted.measurements, "unreduced", fitted.unreduced, "elements",
             array_of(fitted.elements, [](const Element &element) {
                 return Json("name", element.name, "before", Exact{element.before}, "after", Exact{element.after},
                             "sigma_before", element.sigma_before, "sigma_after", element.sigma_after, "change_sigmas",
                             if_known(element.sigma_before > 0, element.change()));
             }));
    std::vector<std::vector<double>> covariance;
    for (size_t i = 0; i < TOLIMAN_SKY_ELEMENTS; i++)
        covariance.emplace_back(&result.covariance[i * TOLIMAN_SKY_ELEMENTS],
                                &result.covariance[i * TOLIMAN_SKY_ELEMENTS] + TOLIMAN_SKY_ELEMENTS);
    json.set("covariance", covariance, "chi_square", result.chi_square, "chi_square_sigma", result.chi_square_sigma,
             "largest_residual", result.largest_residual, "goodness", toliman_constant_name(result.goodness),
             "jitter_uas", result.jitter_arcsec * 1e6, "outliers", result.outliers, "rms_uas", result.rms_arcsec * 1e6,
             "scale", result.scale, "scale_sigma", result.scale_sigma, "iterations", result.iterations, "diagnosis",
             fitted.diagnosis, "out", text_or_null(is_unusable(fitted) ? "" : options.out));
    print_stdout(json.text());
}

void refit(RefitOptions &options, Progress &progress) {
    if (!(options.scale_sigma >= 0 && options.scale_sigma < 1))
        throw Failure(kExitUsage, formatted("--scale-sigma %g: must be in [0, 1)", options.scale_sigma));
    if (!options.out.empty())
        check_output(options.out);
    options.samples.leap_seconds = options.reduction.observer.leap_seconds();
    const Fitted fitted = fit(options, progress);
    progress.clear();
    warn(fitted, progress);
    if (!options.out.empty() && !is_unusable(fitted))
        save(fitted.sky.get(), options.out);
    (options.as_json ? print_fit_json : print_fit_table)(options, fitted);
    if (is_unusable(fitted))
        throw Failure(
            kExitRejected,
            formatted("%s: chi-square %.4g: times, unit or sigmas are wrong, or the model lacks an effect: the "
                      "orbit must not be used%s",
                      options.series.c_str(), fitted.result.chi_square,
                      options.out.empty() ? "" : (", " + options.out + " is not written").c_str()));
}

} // namespace

void add_refit(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "refit");
    auto options = std::make_shared<RefitOptions>();
    add_system(*command, options->system);
    add_option(command, "SERIES", options->series, "")->required();
    options->samples.add_to(*command, false);
    options->reduction.add_to(*command, nullptr);
    command->add_option("--scale-sigma", options->scale_sigma);
    add_option(command, "--out", options->out, "FILE");
    command->add_flag("--json", options->as_json);
    set_action(*command, context, options, refit);
}

} // namespace cli
