#include "frames/bank_training.hpp"

#include <algorithm>

#include "common/failure.hpp"
#include "common/stop.hpp"
#include "common/text.hpp"
#include "scenes/dates.hpp"

namespace cli {

namespace {

constexpr char kOfFrames[] = "frames";

// Sets the dates of the options; both stay 0, the library's default, for those of the frames.
void set_dates(const BankRequest &request, const Scene &scene, toliman_bank_options &options) {
    if (request.dates == kOfFrames)
        return;
    const size_t colon = request.dates.find(':');
    const std::optional<double> first = year_of(request.dates.substr(0, colon)),
                                last = colon == std::string::npos ? std::nullopt
                                                                  : year_of(request.dates.substr(colon + 1));
    if (!first || !last || *first >= *last)
        throw Failure(kExitUsage, "--bank " + request.dates +
                                      ": must be DATE:DATE, the earlier one first, e.g. 2026.5:2029.5 or "
                                      "2026-07-02:2029-07-02, or `frames` for the dates of the scene's frames");
    const std::optional<double> zero = date_of(scene);
    if (!zero)
        throw Failure(kExitUsage,
                      "--bank " + request.dates + ": the stars of " + scene.path +
                          " follow no orbit (binary.moving), so that its frames have no dates: give --bank " +
                          kOfFrames);
    options.first_days = (*first - *zero) * kDaysPerYear;
    options.last_days = (*last - *zero) * kDaysPerYear;
}

toliman::network_bank new_bank(const BankRequest &request, const SceneFit &of) {
    auto options = request.options;
    set_dates(request, of.scene, options);
    toliman_bank *made = nullptr;
    const toliman_status status = toliman_bank_create(of.fit.get(), &options, &made);
    if (status == TOLIMAN_E_ARGUMENT) { // of the other options, the command line has checked the ranges
        const std::string field = toliman_last_error_field();
        if (field == "prediction")
            throw Failure(kExitUsage, "--bank " + request.dates + ": the fit of " + of.scene.path +
                                          " does not cover these dates: a larger cadence.frames extends it");
        if (field == "options")
            throw Failure(kExitUsage, "--bank " + request.dates + ", --places, --spacing: " + toliman_last_error());
    }
    toliman::check(status);
    return toliman::network_bank(made);
}

toliman::network_bank resumed_bank(const std::string &path) {
    toliman::network_bank bank = load_bank(path);
    const auto info = info_from<toliman_bank_info>(toliman_bank_get_info, bank.get());
    if (info.trained_networks == info.networks)
        throw Failure(kExitUsage, path + ": contains no training to resume");
    return bank;
}

} // namespace

BankTraining::BankTraining(const BankRequest &request, Progress &progress)
    : scene_fit_(request.scene, request.free, progress),
      bank_(request.resume.empty() ? new_bank(request, scene_fit_) : resumed_bank(request.resume)) {
    check_bank(bank_, scene_fit_.fit, request.resume, request.scene, request.free);
}

bool BankTraining::run(Progress &progress) {
    auto how = toliman::sized<toliman_bank_train_options>();
    how.progress = Progress::callback;
    how.progress_data = &progress;
    const toliman_status status = toliman_bank_train(bank_.get(), scene_fit_.fit.get(), &how);
    progress.clear();
    if (status != TOLIMAN_E_CANCELLED)
        toliman::check(status);
    return status == TOLIMAN_OK;
}

std::vector<unsigned char> BankTraining::bytes(int32_t encoding) const {
    return bytes_of([&](unsigned char *data, size_t capacity, size_t *size) {
        return toliman_bank_save(bank_.get(), encoding, data, capacity, size);
    });
}

std::string BankTraining::result() const {
    const toliman_bank_info all = info();
    double least = 1, most = 0;
    for (uint32_t i = 0; i < all.networks; i++) {
        auto network = toliman::sized<toliman_bank_network>();
        toliman::check(toliman_bank_get_network(bank_.get(), i, &network));
        least = std::min(least, network.cosine);
        most = std::max(most, network.cosine);
    }
    const std::string until = last_day_of(bank_, scene_fit_.fit, scene_fit_.scene);
    return formatted("%u networks, %u places at %u dates, cosine %.4f to %.4f", all.networks, all.places, all.dates,
                     least, most) +
           (until.empty() ? "" : formatted(", efficiency of %g until %s", kLeastEfficiency, until.c_str()));
}

} // namespace cli
