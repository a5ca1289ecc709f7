#include "frames/bank.hpp"

#include "common/content.hpp"
#include "scenes/dates.hpp"

namespace cli {

toliman::network_bank load_bank(const std::string &path) {
    need(path, "a bank of toliman networks", {Content::bank});
    return toliman::make<toliman::network_bank>(toliman_bank_load_file, path.c_str(), nullptr);
}

toliman::network_bank trained_bank(const std::string &path) {
    toliman::network_bank bank = load_bank(path);
    const auto info = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank.get());
    if (info.trained_networks < info.networks)
        malformed(path,
                  formatted("contains an interrupted training, %lld of %lld networks: continue it with `toliman "
                            "train --resume`",
                            static_cast<long long>(info.trained_networks), static_cast<long long>(info.networks)));
    return bank;
}

void check_bank(const toliman::network_bank &bank, const toliman::frame_fit &fit, const std::string &path,
                const std::string &scene, const std::string &free) {
    auto undisturbed = toliman::sized<toliman_bank_result>();
    const toliman_status status = toliman_bank_predict(bank.get(), fit.get(), nullptr, &undisturbed);
    if (status == TOLIMAN_E_MISMATCH)
        throw Failure(kExitUsage, path + ": was trained for another scene or other free parameters than " + scene +
                                      free_text(free) + ": give scene and --free of the training");
    toliman::check(status);
}

std::string free_text(const std::string &free) {
    return free.empty() ? "" : " --free \"" + free + "\"";
}

double efficiency_at(const toliman::network_bank &bank, const toliman::frame_fit &fit, double days) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.time_days = days;
    auto undisturbed = toliman::sized<toliman_bank_result>();
    toliman::check(toliman_bank_predict(bank.get(), fit.get(), &prediction, &undisturbed));
    return undisturbed.efficiency;
}

std::string use_of(const toliman::network_bank &bank, const toliman::frame_fit &fit, const Scene &scene) {
    const std::optional<double> zero = date_of(scene);
    if (!zero)
        return "";
    const double last = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank.get()).last_days,
                 efficiency = efficiency_at(bank, fit, last);
    if (efficiency < kLeastEfficiency)
        return formatted("an efficiency of %.3f on its last day, %s", efficiency, day_text(*zero, last).c_str());
    double days = 0;
    toliman::check(toliman_bank_get_renewal(bank.get(), fit.get(), kLeastEfficiency, &days));
    return formatted("an efficiency of at least %g until %s", kLeastEfficiency, day_text(*zero, days).c_str());
}

namespace {

// Those options of the training that are not the defaults.
std::string training_text(const toliman_bank_info &info) {
    std::string text;
    if (const long places = std::lround(std::sqrt(static_cast<double>(info.places))); places != 3)
        text += formatted(" --places %ld", places);
    if (info.spacing_px != 0.5)
        text += formatted(" --spacing %g", info.spacing_px);
    if (info.steps != 600)
        text += formatted(" --steps %u", info.steps);
    if (info.layout != std::string("flight"))
        text += std::string(" --layout ") + info.layout;
    return text;
}

} // namespace

std::string renewal_of(const toliman::network_bank &bank, const toliman::frame_fit &fit, const Scene &scene,
                       const std::string &file, const std::string &free) {
    const std::optional<double> zero = date_of(scene);
    if (!zero)
        return "";
    const auto info = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank.get());
    const double next = 2 * info.last_days - info.first_days;
    return formatted("the bank has %s; train the next one with: toliman train %s --bank %s:%s%s%s --out FILE",
                     use_of(bank, fit, scene).c_str(), file.c_str(), day_text(*zero, info.last_days).c_str(),
                     day_text(*zero, next).c_str(), training_text(info).c_str(), free_text(free).c_str());
}

} // namespace cli
