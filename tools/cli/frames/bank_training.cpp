#include "frames/bank_training.hpp"

#include "common/job_journal.hpp"
#include "scenes/dates.hpp"

namespace cli {

namespace {

constexpr char kOfFrames[] = "frames";

struct Years {
    double first, last;
};

// Nothing for kOfFrames.
std::optional<Years> years_of(const std::string &dates) {
    if (dates == kOfFrames)
        return std::nullopt;
    const size_t colon = dates.find(':');
    const auto first = year_of(dates.substr(0, colon)),
               last = colon == std::string::npos ? std::nullopt : year_of(dates.substr(colon + 1));
    if (!first || !last || *first >= *last)
        throw Failure(kExitUsage, "--bank " + dates +
                                      ": must be DATE:DATE, the earlier one first, e.g. 2026.5:2029.5 or "
                                      "2026-07-02:2029-07-02, or `frames` for the dates of the scene's frames");
    return Years{*first, *last};
}

// Sets the dates of the options; both stay 0, the library's default, for those of the frames.
void set_dates(const BankRequest &request, const Scene &scene, toliman_bank_options &options) {
    const std::optional<Years> years = years_of(request.dates);
    if (!years)
        return;
    const std::optional<double> zero = date_of(scene);
    if (!zero)
        throw Failure(kExitUsage,
                      "--bank " + request.dates + ": the stars of " + scene.path +
                          " follow no orbit (binary.moving), so that its frames have no dates: give --bank " +
                          kOfFrames);
    options.first_days = (years->first - *zero) * kDaysPerYear;
    options.last_days = (years->last - *zero) * kDaysPerYear;
}

// An error of the library about dates or the number of networks, in terms of options.
[[noreturn]] void refuse_dates(const BankRequest &request, const SceneFit &of, const toliman::error &error) {
    std::string why = error.what();
    const std::string prefix = "options: ";
    if (why.rfind(prefix, 0) == 0)
        why.erase(0, prefix.size());
    if (error.field() == std::string("prediction"))
        why = "the fit of " + of.scene.path + " does not cover these dates: a larger cadence.frames extends it";
    throw Failure(kExitUsage, "--bank " + request.dates + ": " + why);
}

toliman::network_bank new_bank(const BankRequest &request, const SceneFit &of) {
    const StopLimit limit;
    auto options = request.options;
    set_dates(request, of.scene, options);
    try {
        return toliman::make<toliman::network_bank>(toliman_bank_create, of.fit.get(), &options);
    } catch (const toliman::error &error) {
        if (error.status() != TOLIMAN_E_ARGUMENT)
            throw;
        refuse_dates(request, of, error);
    }
}

std::string result_of(const toliman::network_bank &bank, const SceneFit &of) {
    const auto all = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank.get());
    double least = 1, most = 0;
    const toliman_bank *const made = bank.get();
    for (const toliman_bank_network &network : items_of(toliman_bank_get_network, made, all.networks)) {
        least = std::min(least, network.cosine);
        most = std::max(most, network.cosine);
    }
    const std::string use = use_of(bank, of.fit, of.scene);
    return formatted("%lld networks (places x dates: %lld x %lld), cosine %.4f to %.4f",
                     static_cast<long long>(all.networks), static_cast<long long>(all.places),
                     static_cast<long long>(all.dates), least, most) +
           (use.empty() ? "" : ", " + use);
}

} // namespace

void train_bank(const BankRequest &request, OutputFile &out, Progress &progress) {
    years_of(request.dates); // before files are read
    const std::string &journal = request.journal;
    if (!journal.empty() && !request.resumes)
        remove_journal(journal);
    const SceneFit of = fit_of_scene(request.scene, request.free, request.bad_pixels, progress);
    const toliman::network_bank bank = new_bank(request, of);
    auto how = with_progress<toliman_bank_train_options>(progress);
    how.journal = journal.empty() ? nullptr : journal.c_str();
    const toliman_status status = toliman_bank_train(bank.get(), of.fit.get(), &how);
    progress.clear();
    if (status != TOLIMAN_OK && toliman_last_error_field() == journal)
        refuse_journal(toliman::error(status));
    if (status == TOLIMAN_E_CANCELLED) {
        if (!journal.empty() && exists(journal))
            progress.tell("the same command with --resume continues from " + journal);
        stop_if_asked();
    }
    toliman::check(status);
    const std::vector<unsigned char> bytes = bytes_of([&](unsigned char *data, size_t capacity, size_t *size) {
        return toliman_bank_save(bank.get(), request.encoding, data, capacity, size);
    });
    const auto write = [&] {
        out.write(bytes);
        out.commit();
    };
    journal.empty() ? write() : write_and_remove(journal, write);
    std::fprintf(stderr, "%s: %s, %s\n", request.out.c_str(), result_of(bank, of).c_str(),
                 size_text(static_cast<double>(bytes.size())).c_str());
}

} // namespace cli
